"""What other processes do to a store: python store_processes.py ROLE POSES PICTURES [SECONDS]."""

from __future__ import annotations

import sys
import time

from snapfit.server.mailbox import Mailbox
from snapfit.server.pose_store import PoseStore, StoreNames


def message(number: int) -> bytes:
    """A message that shows by itself whether it is whole; the next one is longer."""
    return number.to_bytes(8, "little") * (200 + number % 1000)


def is_whole(payload: bytes) -> bool:
    number = int.from_bytes(payload[:8], "little")
    return payload == message(number)


def write_for_ever(mailbox: Mailbox) -> None:
    number = mailbox.latest
    while True:
        number += 1
        mailbox.write(message(number))


def read(mailbox: Mailbox, seconds: float) -> int:
    """Reads as fast as it can; how many different messages it saw."""
    end_s = time.monotonic() + seconds
    latest, seen = 0, 0
    while time.monotonic() < end_s:
        got = mailbox.read()
        if got is None:
            continue
        if not is_whole(got.payload):
            raise SystemExit("torn")
        if got.generation < latest:
            raise SystemExit("an older message came after a newer one")
        if int.from_bytes(got.payload[:8], "little") != got.generation:
            raise SystemExit("the generation is another message's")
        seen += got.generation > latest
        latest = got.generation
    return seen


def main() -> None:
    role, poses, pictures = sys.argv[1:4]
    store = PoseStore.attach(StoreNames(poses, pictures))
    if role == "write":
        write_for_ever(store.snapshots)
    elif role == "read":
        sys.stdout.write(str(read(store.snapshots, float(sys.argv[4]))))
    elif role == "touch":
        store.beat()
    store.close()


if __name__ == "__main__":
    main()
