#!/usr/bin/env bash
# Every number that the Python package returns is that of the program, to the bit, over all examples.
set -u
. tests/support/tap.sh
needs_python
RICOCHET=$ricochet tools/python tests/python/test_numbers.py
