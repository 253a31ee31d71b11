"""Rows on several threads where no thread can be started, and where nobody waits for one any longer."""

from __future__ import annotations

import signal
import threading
import weakref
from contextlib import suppress

import numpy as np
import pytest
from patience import HANG

from symdyn.runtime.c_module import run_rows

PARTS = [(0, 64), (64, 128), (128, 192)]


@pytest.mark.parametrize("started", [0, 1])
def test_the_caller_does_what_no_thread_can_be_started_for(started: int, monkeypatch: pytest.MonkeyPatch) -> None:
    begin, begun = threading.Thread.start, []

    def start(thread: threading.Thread) -> None:
        if len(begun) == started:
            raise RuntimeError("can't start new thread")
        begun.append(thread)
        begin(thread)

    monkeypatch.setattr(threading.Thread, "start", start)
    done = np.zeros(192)

    def call(count: int, place: int) -> None:
        done[place : place + count] = 1

    run_rows(call, [0], [1], PARTS)
    assert done.all()


@pytest.mark.skipif(not hasattr(signal, "pthread_kill"), reason="no signals to threads here")
def test_arrays_stay_while_a_thread_works_that_a_second_ctrl_c_did_not_wait_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first, waited, interrupted, on, ended = (threading.Event() for _ in range(5))
    join = threading.Thread.join

    def interrupt(*_: object) -> None:
        if not interrupted.is_set():
            interrupted.set()
            raise KeyboardInterrupt

    def waiting(thread: threading.Thread, timeout: float | None = None) -> None:
        waited.set()
        join(thread, timeout)

    def call(_: int, place: int) -> None:
        if not place:
            first.set()
            raise KeyboardInterrupt
        assert first.wait(HANG)
        assert waited.wait(HANG)  # the caller is about to wait for this thread, or does
        while not interrupted.wait(0.05):  # Python overlooks a signal that comes just before it waits for a lock
            signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        on.wait(HANG)
        ended.set()

    monkeypatch.setattr(threading.Thread, "join", waiting)
    array = np.zeros(128)
    there = weakref.ref(array)
    before = signal.signal(signal.SIGINT, interrupt)
    try:
        with suppress(KeyboardInterrupt):
            run_rows(call, [0], [1], PARTS[:2], held=array)
    finally:
        signal.signal(signal.SIGINT, before)
    del array
    try:
        assert interrupted.is_set()
        assert there() is not None, "the thread still writes to it"
    finally:
        on.set()
    assert ended.wait(HANG)
