# The command line: docker run --rm --volume "$PWD:/work" vpf-sim drive town04 --video town04.mp4
FROM python:3.13-slim AS build
WORKDIR /source
COPY pyproject.toml setup.py README.md LICENSE MANIFEST.in ./
COPY building building
COPY vpf_sim vpf_sim
COPY envs envs
COPY controllers controllers
COPY scenarios scenarios
RUN python -m venv /opt/vpf_sim && /opt/vpf_sim/bin/pip install --no-cache-dir '.[video]'

FROM python:3.13-slim
COPY --from=build /opt/vpf_sim /opt/vpf_sim
RUN useradd --create-home --uid 1000 driver && mkdir /work && chown driver /work
USER driver
WORKDIR /work
ENTRYPOINT ["/opt/vpf_sim/bin/vpf-sim"]
CMD ["--help"]
