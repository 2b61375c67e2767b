"""Errors of the estimation."""

from passafe.errors import NotAllowedError


class IdentifyError(NotAllowedError):
    """Logs from which nothing can be estimated."""

    prefix = "identify "
