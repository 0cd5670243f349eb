#!/usr/bin/env python3
"""Prints the type hashes of the messages that `rosbags` knows of a distribution, as one JSON object: store_hashes.py DISTRIBUTION."""

import json
import sys

from rosbags.typesys import Stores, get_typestore

store = get_typestore(Stores[f"ROS2_{sys.argv[1].upper()}"])
print(json.dumps({name: store.hash_rihs01(name) for name in store.fielddefs}))
