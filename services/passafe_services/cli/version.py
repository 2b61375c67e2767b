"""The version that ``passafe --version`` prints."""

from importlib.metadata import version


def version_text() -> str:
    """Return the name and the version of the installed distribution."""
    return f"passafe {version('passafe')}"
