# The server in a container: docker build -t movingout .
# deploy/compose.yaml runs it behind Caddy, with PostgreSQL.
FROM python:3.11-slim-bookworm AS build
WORKDIR /build
COPY . .
RUN python -m pip wheel --no-cache-dir --wheel-dir /wheels --require-hashes --requirement constraints/serving.txt \
    && python -m pip wheel --no-cache-dir --wheel-dir /wheels --no-deps .

FROM python:3.11-slim-bookworm
# The versions are those of the wheels, of which there is one each.
# hadolint ignore=DL3013
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
    python -m pip install --no-cache-dir --no-index --find-links /wheels 'moving-out-live[postgres]' \
    && useradd --system --uid 10001 --home-dir /data movingout \
    && install --directory --owner movingout /data
USER 10001
WORKDIR /data
VOLUME /data
ENV PYTHONUNBUFFERED=1
# Loopback only: a proxy in the same network namespace reaches it, nothing else does.
ENTRYPOINT ["movingout"]
CMD ["play", "--data", "/data", "--proxy", "127.0.0.1"]
