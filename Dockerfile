# One small image for every process: passafe installed from its wheel, no shell scripts, no root, nothing to write to.
# `docker compose build` builds it; docs/operations.md explains how it is run.

# Any image with Python 3.11 or newer, pip and venv.
ARG BASE=docker.io/library/python:3.12-slim-bookworm

FROM ${BASE} AS build
# A package index of one's own, or none: PIP_NO_INDEX=1 PIP_FIND_LINKS=/wheels with the folder mounted there.
ARG PIP_INDEX_URL
ARG PIP_NO_INDEX
ARG PIP_FIND_LINKS
WORKDIR /build
RUN python3 -m venv /opt/passafe
COPY . .
RUN /opt/passafe/bin/python -m pip wheel --no-deps --no-cache-dir --wheel-dir wheels . \
    && /opt/passafe/bin/python -m pip install --no-cache-dir --no-compile --constraint constraints.txt \
        "passafe[run] @ file://$(echo "$PWD"/wheels/passafe-*.whl)" \
    && /opt/passafe/bin/python -m pip uninstall --quiet --yes pip setuptools \
    && python3 deploy/trim.py /opt/passafe \
    && python3 -m compileall -q /opt/passafe

FROM ${BASE}
COPY --from=build /opt/passafe /opt/passafe
RUN install -d -o 10001 -g 10001 /logs
# Logs go to /logs, reports of health to /dev/shm; nothing else is written, so that the root can be read-only.
ENV PATH=/opt/passafe/bin:$PATH PYTHONDONTWRITEBYTECODE=1 PYTHONUNBUFFERED=1
USER 10001:10001
WORKDIR /logs
ENTRYPOINT ["passafe"]
CMD ["--help"]
