# Highwall on Debian 12, from its packages: the programs, the Python module, and what C++ programs need.
#   docker build -t highwall .
#   docker run --rm highwall smoke_test
#   docker run --rm -v "$PWD:/data" highwall highwall slam --dataset /data/SEQUENCE --out /data/run
FROM debian:12 AS build
COPY . /highwall
WORKDIR /highwall
RUN ./scripts/install_dependencies --all && ./scripts/make_packages

FROM debian:12
COPY --from=build /highwall/build-package/*.deb /tmp/
RUN apt-get update \
 && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
    /tmp/*.deb cmake g++ make pkgconf libopencv-dev \
 && rm -rf /var/lib/apt/lists/* /tmp/*.deb
COPY scripts/smoke_test /usr/local/bin/smoke_test
CMD ["highwall", "--help"]
