"""Importers of foreign flight recordings: readers, column maps, checks, and the FlightLog writer."""

VERSION = "1"
