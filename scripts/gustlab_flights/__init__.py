"""Flight logs for other programs and for the eye: exports, films, a viewer."""
