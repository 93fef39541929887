"""Tests marked `slow` run where GUSTLAB_EVERY_TEST is set (scripts/test.sh --all)."""

import os

import pytest

EVERY = "GUSTLAB_EVERY_TEST" in os.environ


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: scripts/test.sh --all runs it")


def pytest_collection_modifyitems(items):
    for item in items:
        if item.get_closest_marker("slow") and not EVERY:
            item.add_marker(pytest.mark.skip(reason="slow: scripts/test.sh --all runs it"))
