"""The latest message in shared memory: never torn, whoever dies."""

from __future__ import annotations

import pytest

from snapfit.server.errors import StoreError
from snapfit.server.mailbox import Mailbox

CAPACITY_BYTES = 128


@pytest.fixture
def memory() -> bytearray:
    return bytearray(Mailbox.size_bytes(CAPACITY_BYTES))


def test_it_is_empty_before_the_first_message(memory: bytearray) -> None:
    mailbox = Mailbox(memoryview(memory))
    assert mailbox.read() is None
    assert mailbox.latest == 0


def test_the_latest_message_wins(memory: bytearray) -> None:
    writer, reader = Mailbox(memoryview(memory)), Mailbox(memoryview(memory))
    for number in range(1, 6):
        assert writer.write(b"message %d" % number) == number
    assert reader.read() == (5, b"message 5")
    assert reader.read() == (5, b"message 5")


def test_a_message_may_be_empty_or_fill_its_slot(memory: bytearray) -> None:
    mailbox = Mailbox(memoryview(memory))
    for payload in (b"", b"x" * CAPACITY_BYTES, b"y"):
        generation = mailbox.write(payload)
        assert mailbox.read() == (generation, payload)


def test_a_message_that_is_too_large_is_refused_and_harms_nothing(memory: bytearray) -> None:
    mailbox = Mailbox(memoryview(memory))
    mailbox.write(b"good")
    with pytest.raises(StoreError, match="129 bytes does not fit the 128 bytes"):
        mailbox.write(b"x" * (CAPACITY_BYTES + 1))
    assert mailbox.read() == (1, b"good")


@pytest.mark.parametrize("written_bytes", range(64, 64 + 64 + CAPACITY_BYTES, 8))
def test_a_writer_that_died_half_way_harms_nobody(memory: bytearray, written_bytes: int) -> None:
    Mailbox(memoryview(memory)).write(b"one")
    Mailbox(memoryview(memory)).write(b"two")
    # The third message goes into the second slot, over the first; the writer dies in it.
    slot_bytes = 64 + CAPACITY_BYTES
    memory[64 + slot_bytes : slot_bytes + written_bytes] = b"\xa5" * (written_bytes - 64)
    heir = Mailbox(memoryview(memory))
    assert heir.read() == (2, b"two")
    assert heir.write(b"three") == 3
    assert heir.read() == (3, b"three")


def test_stores_that_arrive_out_of_order_are_not_taken_for_a_message(memory: bytearray) -> None:
    mailbox = Mailbox(memoryview(memory))
    mailbox.write(b"one")
    mailbox.write(b"two")
    third = bytearray(memory)
    Mailbox(memoryview(third)).write(b"six")
    # A reader that sees the new `latest` and all of the slot but its payload.
    place = bytes(third).index(b"six")
    third[place : place + 3] = b"one"
    with pytest.raises(StoreError, match="damaged"):
        Mailbox(memoryview(third)).read()
    # And one that sees `latest` alone.
    memory[0] = 3
    with pytest.raises(StoreError, match="damaged"):
        mailbox.read()
