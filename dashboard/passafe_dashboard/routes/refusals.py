"""Answer what a request got wrong, in JSON that any text of a request fits into."""

import json
from typing import Final

from fastapi import Request, Response
from fastapi.exceptions import RequestValidationError

UNPROCESSABLE: Final = 422


async def answer_invalid(_request: Request, error: Exception) -> Response:
    """Return an answer that says of each problem of a request where and what it is.

    What was got is left out: it may be NaN, infinite or half a character, which JSON cannot hold.
    """
    problems = error.errors() if isinstance(error, RequestValidationError) else ()
    detail = [{key: problem[key] for key in ("type", "loc", "msg")} for problem in problems]
    return Response(json.dumps({"detail": detail}), UNPROCESSABLE, media_type="application/json")
