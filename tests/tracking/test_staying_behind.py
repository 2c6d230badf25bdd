"""What goes on beside the tracker leaves the cores to it."""

import os
import sys
import threading

import pytest

from snapfit.tracking.threads import stay_behind


@pytest.mark.skipif(sys.platform != "linux", reason="threads have priorities of their own on Linux")
def test_only_the_thread_itself_stays_behind():
    before = os.getpriority(os.PRIO_PROCESS, threading.get_native_id())
    found = []

    def beside():
        stay_behind()
        found.append(os.getpriority(os.PRIO_PROCESS, threading.get_native_id()))

    thread = threading.Thread(target=beside)
    thread.start()
    thread.join()
    assert found == [19]
    assert os.getpriority(os.PRIO_PROCESS, threading.get_native_id()) == before
