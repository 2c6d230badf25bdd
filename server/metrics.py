"""`/metrics`: what Prometheus reads; made when it is asked for, but for the requests' latencies."""

from __future__ import annotations

from collections.abc import Iterator

from prometheus_client import CollectorRegistry, Counter, Histogram, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily
from prometheus_client.metrics_core import Metric
from prometheus_client.registry import Collector

from snapfit.server.station import Station
from snapfit.server.stations import Stations

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"

_BUCKETS_S = (0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 10, 60)


class Metrics:
    """The metrics of one server.

    Args:
        stations: told of when somebody asks.
    """

    def __init__(self, stations: Stations) -> None:
        self._registry = CollectorRegistry()
        self._registry.register(StationCollector(stations))
        self._latency = Histogram(
            "snapfit_request_seconds",
            "From a request's arrival to the end of its answer; streams are left out.",
            ["method", "route", "status"],
            registry=self._registry,
            buckets=_BUCKETS_S,
        )
        self._series: dict[tuple[str, str, int], Histogram] = {}
        self.dropped = Counter(
            "snapfit_dropped_clients",
            "Clients of streams that did not read.",
            registry=self._registry,
        )

    def observe(self, method: str, route: str, status: int, seconds: float) -> None:
        """Count a request that was answered."""
        key = (method, route, status)
        series = self._series.get(key)
        if series is None:
            series = self._series[key] = self._latency.labels(method, route, str(status))
        series.observe(seconds)

    def text(self) -> bytes:
        """In Prometheus' text format."""
        return generate_latest(self._registry)


class StationCollector(Collector):
    """Reads the stations when Prometheus asks.

    Args:
        stations: all of them.
    """

    def __init__(self, stations: Stations) -> None:
        self._stations = stations

    def collect(self) -> Iterator[Metric]:
        """All metrics of all stations."""
        families = _Families()
        for station in self._stations:
            families.add(station)
        yield from families.all()


class _Families:
    """The metrics of stations, gathered."""

    def __init__(self) -> None:
        one, part, state = ["station"], ["station", "part"], ["station", "state"]
        self._up = GaugeMetricFamily("snapfit_worker_up", "1 while the worker runs.", labels=one)
        self._stale = GaugeMetricFamily(
            "snapfit_stale", "1 while the snapshot is not to be relied on.", labels=one
        )
        self._age = GaugeMetricFamily(
            "snapfit_pose_age_seconds", "From the exposure of the latest snapshot.", labels=one
        )
        self._frame = GaugeMetricFamily(
            "snapfit_frame_seconds", "Tracking a frame, median of the last 300.", labels=one
        )
        self._frames = CounterMetricFamily(
            "snapfit_frames", "Frames tracked by this run of the worker.", labels=one
        )
        self._bad = CounterMetricFamily(
            "snapfit_bad_frames", "Frames that could not be used, of this run.", labels=one
        )
        self._restarts = CounterMetricFamily(
            "snapfit_worker_restarts", "How often the worker was started again.", labels=one
        )
        self._confidence = GaugeMetricFamily(
            "snapfit_part_confidence", "That a part's pose is right.", labels=part
        )
        self._tracked = GaugeMetricFamily(
            "snapfit_part_tracked", "1 while a part is seen and followed.", labels=part
        )
        self._state = GaugeMetricFamily(
            "snapfit_assembly_state", "1 for the state that holds.", labels=state
        )
        self._state_confidence = GaugeMetricFamily(
            "snapfit_assembly_confidence", "That the assembly state holds.", labels=one
        )
        self._state_seconds = CounterMetricFamily(
            "snapfit_assembly_state_seconds", "Time spent in each state.", labels=state
        )

    def add(self, station: Station) -> None:
        """One station."""
        worker, name = station.info().worker, [station.name]
        self._up.add_metric(name, float(worker.pid is not None))
        self._restarts.add_metric(name, worker.restarts)
        self._frames.add_metric(name, worker.frames)
        self._bad.add_metric(name, worker.bad_frames)
        if worker.frame_ms is not None:
            self._frame.add_metric(name, worker.frame_ms / 1e3)
        self._stale.add_metric(name, float(not station.is_ready()))
        snapshot = station.snapshot()
        if snapshot is None:
            return
        self._age.add_metric(name, (station.now_us() - snapshot["captured_at_us"]) / 1e6)
        for part in snapshot["parts"]:
            labels = [station.name, part["part"]]
            self._confidence.add_metric(labels, part["confidence"])
            self._tracked.add_metric(labels, float(part["status"] == "tracked"))
        if snapshot.get("assembly") is not None:
            self._state.add_metric([station.name, snapshot["assembly"]["state"]], 1)
            self._state_confidence.add_metric(name, snapshot["assembly"]["confidence"])
        for state, seconds in station.news.state_clock.seconds().items():
            self._state_seconds.add_metric([station.name, state], seconds)

    def all(self) -> Iterator[Metric]:
        """Those that have something to say."""
        for family in vars(self).values():
            if family.samples:
                yield family
