"""Stands for a translator under test. translate.py INPUT OUTPUT"""
import sys

import patchwright

patchwright.read(sys.argv[1]).write(sys.argv[2])
