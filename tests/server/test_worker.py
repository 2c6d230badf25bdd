"""The worker as a process: faults, deaths, restarts, ends."""

from __future__ import annotations

import os
import signal
import time

import pytest
from harness import is_alive, once_there, running, segments, segments_of, wait_for
from patience import within
from scripted_pipeline import END_AFTER_FRAMES, FRAME_RATE_HZ

KILLS = 2


def test_a_killed_worker_is_back_soon_and_nothing_is_lost_meanwhile() -> None:
    with running() as server:
        server.wait_ready()
        first_start_s = time.monotonic() - server.started_at_s
        for restart in range(1, KILLS + 1):
            before = server.get("/v1/poses").json()
            killed_at_s = time.monotonic()
            os.kill(server.worker()["pid"], signal.SIGKILL)
            stale = wait_for(lambda: (it := server.get("/v1/poses").json())["stale"] and it)
            assert time.monotonic() - killed_at_s < within(5)
            assert stale["boot_id"] == before["boot_id"]
            assert stale["seq"] >= before["seq"]
            assert stale["age_us"] > 0
            assert stale["parts"][0]["position"] is not None
            answer = server.get("/v1/poses")
            assert answer.status_code == 200
            assert answer.headers["etag"].endswith('-stale"')
            assert server.get("/readyz").status_code == 503
            assert server.get("/v1/poses/jaw").json()["stale"]
            fresh = wait_for(lambda: not (it := server.get("/v1/poses").json())["stale"] and it)
            away_s = time.monotonic() - killed_at_s
            assert away_s < max(within(3), 2 * first_start_s)
            assert fresh["boot_id"] != before["boot_id"]
            assert fresh["seq"] <= away_s * FRAME_RATE_HZ + 1
            worker = server.worker()
            assert worker["restarts"] == restart
            assert worker["last_exit"] == "was killed by SIGKILL"


def test_etag_changes_when_a_snapshot_becomes_stale() -> None:
    with running("end") as server:
        wait_for(server.answers)
        wait_for(lambda: server.get("/v1/poses").status_code == 200)
        wait_for(lambda: server.worker()["phase"] == "ended")
        stale = wait_for(lambda: (it := server.get("/v1/poses")).json()["stale"] and it)
        assert stale.json()["seq"] == END_AFTER_FRAMES
        fresh_etag = stale.headers["etag"].replace("-stale", "-fresh")
        again = server.get("/v1/poses", headers={"If-None-Match": fresh_etag})
        assert again.status_code == 200
        assert (
            server.get("/v1/poses", headers={"If-None-Match": again.headers["etag"]}).status_code
            == 304
        )
        assert server.get("/v1/poses").json()["age_us"] > stale.json()["age_us"]
        # The last frame can still be looked at; the worker stays, and is not started again.
        assert once_there(lambda: server.get("/v1/frame.jpg")).status_code == 200
        assert server.worker()["restarts"] == 0


def test_bad_frames_are_counted_logged_once_and_skipped() -> None:
    with running("bad-frames") as server:
        server.wait_ready()
        worker = wait_for(lambda: (it := server.worker())["bad_frames"] >= 5 and it)
        assert worker["frames"] >= 2 * worker["bad_frames"] - 3
        assert "the depth image is missing" in worker["last_bad_frame"]
        _, _, err = server.end()
        assert err.count("the depth image is missing") == 1


def test_a_pose_that_is_not_finite_is_never_published() -> None:
    with running("nan-pose") as server:
        server.wait_ready()
        jaw = server.get("/v1/poses/jaw").json()["pose"]
        assert (jaw["status"], jaw["confidence"]) == ("lost", 0)
        assert jaw["position"] is None
        assert jaw["orientation"] is None
        assert server.get("/v1/poses/base").json()["pose"]["status"] == "tracked"


def test_while_the_worker_starts_the_api_tells_how_far_it_is() -> None:
    with running("slow-start") as server:
        wait_for(server.answers, 2)
        seen = wait_for(lambda: server.worker()["progress"])
        answer = server.get("/v1/poses")
        assert answer.status_code == 503
        assert answer.headers["retry-after"] == "1"
        assert "generating viewpoint models" in answer.json()["detail"]
        assert answer.json()["worker"]["phase"] == "starting"
        assert answer.json()["worker"]["progress"] >= seen
        for path in ("/readyz", "/v1/poses/jaw", "/v1/frame.jpg", "/v1/stations/bench-1/poses"):
            assert server.get(path).status_code == 503, path
        assert server.get("/v1/stations/bench-1").json()["facts"] is None


def test_a_wrong_setting_ends_the_server_with_the_workers_words() -> None:
    with running("refused") as server:
        own = wait_for(lambda: server.process.poll() is not None or segments_of(server.process.pid))
        server.process.wait(timeout=within(60))
        code, _, err = server.end()
        assert code == 1
        assert "refused: demo: no such folder" in err
        assert "Traceback" not in err
        assert own is True or not own & segments()


def test_a_crash_is_started_again_and_the_traceback_is_logged() -> None:
    with running("crash") as server:
        wait_for(server.answers)
        # On a busy machine one of them may be killed for its silence before.
        wait_for(lambda: server.worker()["last_exit"] == "failed with exit code 1")
        assert server.worker()["restarts"] >= 1
        assert server.get("/v1/poses").status_code == 200
        _, _, err = server.end()
        assert "RuntimeError: a bug in a source" in err
        assert "starting it again" in err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_everything_cleanly(number: int) -> None:
    with running() as server:
        pid = server.wait_ready().worker()["pid"]
        own = segments_of(server.process.pid)
        assert len(own) == 2
        begin_s = time.monotonic()
        code, _, err = server.end(number)
        assert (code, err) == (0, "")
        assert time.monotonic() - begin_s < within(10)
        assert not is_alive(pid)
        assert not own & segments()


def test_an_impatient_user_gets_the_same_clean_end() -> None:
    with running() as server:
        pid = server.wait_ready().worker()["pid"]
        own = segments_of(server.process.pid)
        for _ in range(3):
            server.process.send_signal(signal.SIGINT)
            time.sleep(0.03)
        code, _, err = server.end(signal.SIGINT)
        assert (code, err) == (0, "")
        assert not is_alive(pid)
        assert not own & segments()


def test_a_signal_during_a_long_start_ends_everything_too() -> None:
    with running("slow-start") as server:
        wait_for(server.answers)
        pid = wait_for(lambda: server.worker()["pid"])
        own = segments_of(server.process.pid)
        code, _, err = server.end(signal.SIGINT)
        assert (code, err) == (0, "")
        assert not is_alive(pid)
        assert not own & segments()


def test_nothing_survives_a_server_that_is_killed() -> None:
    with running() as server:
        pid = server.wait_ready().worker()["pid"]
        own = segments_of(server.process.pid)
        server.process.kill()
        wait_for(lambda: not is_alive(pid), 3)
        wait_for(lambda: not own & segments(), 3)
