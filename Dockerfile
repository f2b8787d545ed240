# Commands, nodes and the live page in a container, of the locked wheels:
#   docker build --tag mrc .
#   docker run --publish 8080:8080 mrc mrc dashboard --host 0.0.0.0
FROM python:3.11-slim
RUN apt-get update && apt-get install --yes --no-install-recommends make && rm -rf /var/lib/apt/lists/*
COPY . /mobile_robot_control
WORKDIR /mobile_robot_control
RUN make setup
ENV PATH=/mobile_robot_control/.venv/bin:$PATH
CMD ["mrc"]
