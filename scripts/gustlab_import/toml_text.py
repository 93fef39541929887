"""TOML that a stranger wrote: what nests or is dotted without end is an error in it, and takes no time."""

import re
import tomllib

MOST_PARTS = 100  # of a key


def parse_toml(text: str) -> dict:
    """tomllib.TOMLDecodeError for all that is wrong with it."""
    # tomllib takes the square of their number; a dot between two letters counts, also in a string
    if any(len(re.findall(r"""[\w"']\.(?=[\w"'])""", word)) > MOST_PARTS for word in re.split(r"[\n,=\[\]{}]", text.replace(" ", "").replace("\t", ""))):
        raise tomllib.TOMLDecodeError(f"a key of more than {MOST_PARTS} parts")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise tomllib.TOMLDecodeError("nested too deep") from None
