"""temporary"""
from .checks_rows import clean_time, cut


def inspect(flight, column_map, table, from_s, to_s, whole):
    clean_time(flight)
    cut(flight, column_map, from_s, to_s, whole)
