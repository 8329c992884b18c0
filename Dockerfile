# ricochet in a container: docker build -t ricochet . && docker run --rm -v "$PWD:/work" ricochet run study.yaml
# `ricochet view` serves the machine that it runs on, which is the container: `view --save FILE.html` writes a page to open outside.
FROM debian:bookworm-slim AS build
RUN apt-get update && apt-get install -y --no-install-recommends \
        esbuild gcc libc6-dev make meson ninja-build pkg-config python3 \
        liblapacke-dev liblapack-dev libblas-dev libyaml-dev libsqlite3-dev libjansson-dev \
        libhdf5-dev libmatio-dev libmicrohttpd-dev libflint-dev libflint-arb-dev \
    && rm -rf /var/lib/apt/lists/*
COPY . /source
RUN meson setup /build /source -Dtests=false -Dmpi=disabled -Desbuild=true --prefix=/usr/local \
    && ninja -C /build \
    && meson install -C /build --no-rebuild --destdir /installed

FROM debian:bookworm-slim
RUN apt-get update && apt-get install -y --no-install-recommends \
        liblapacke liblapack3 libblas3 libyaml-0-2 libsqlite3-0 libjansson4 \
        libhdf5-103-1 libmatio11 libmicrohttpd12 libflint17 libflint-arb2 gnuplot-nox fonts-liberation \
    && rm -rf /var/lib/apt/lists/*
COPY --from=build /installed /
RUN ldconfig && ricochet --version
WORKDIR /work
ENTRYPOINT ["ricochet"]
CMD ["--help"]
