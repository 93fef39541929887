"""What these commands refuse, with the program's exit codes."""

from gustlab_import.problems import DATA, IO, USAGE, ended
from gustlab_import.problems import ImportFailure as Refusal

__all__ = ["DATA", "IO", "USAGE", "Refusal", "ended"]
