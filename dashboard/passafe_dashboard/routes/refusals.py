"""Answer what a request got wrong, in JSON that any text of a request fits into."""

import json
from typing import Final

from fastapi import Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from starlette.routing import Match

UNPROCESSABLE: Final = 422
NOT_FOUND: Final = 404
METHOD_NOT_ALLOWED: Final = 405
TOO_MANY: Final = 429


async def answer_invalid(_request: Request, error: Exception) -> Response:
    """Return an answer that says of each problem of a request where and what it is.

    What was got is left out: it may be NaN, infinite or half a character, which JSON cannot hold.
    """
    problems = error.errors() if isinstance(error, RequestValidationError) else ()
    detail = [{key: problem[key] for key in ("type", "loc", "msg")} for problem in problems]
    return Response(json.dumps({"detail": detail}), UNPROCESSABLE, media_type="application/json")


async def answer_unknown_name(_request: Request, error: Exception) -> Response:
    """Return an answer that says which name nothing has."""
    return JSONResponse({"detail": str(error)}, NOT_FOUND)


async def answer_too_many(_request: Request, error: Exception) -> Response:
    """Return an answer that says that there is too much to do already."""
    return JSONResponse({"detail": str(error)}, TOO_MANY)


async def answer_not_allowed(request: Request, _error: Exception) -> Response:
    """Return an answer that lists the methods of all routes of the path; Starlette's own lists those of the first."""
    routes = [route for route in request.app.routes if route.matches(request.scope)[0] is not Match.NONE]
    allowed = sorted({method for route in routes for method in getattr(route, "methods", None) or ()})
    return JSONResponse({"detail": "Method Not Allowed"}, METHOD_NOT_ALLOWED, {"Allow": ", ".join(allowed)})
