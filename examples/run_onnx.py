"""Run an exported policy with NumPy and onnxruntime alone: python examples/run_onnx.py best.onnx

pipenav export --policy arm --to onnx --out best.onnx
"""

import json
import sys

import numpy as np
import onnxruntime

session = onnxruntime.InferenceSession(sys.argv[1] if len(sys.argv) > 1 else "best.onnx")
told = json.loads(session.get_modelmeta().custom_metadata_map["pipenav"])
place = {value["name"]: i for i, value in enumerate(told["observation"])}

# A straight robot at rest in open space, in physical units; fill in what your sensors say, 10 times a second.
observation = np.zeros((1, len(place)), np.float32)
for name, i in place.items():
    if name.startswith("ranges"):
        observation[0, i] = told["observation"][i]["scale"]  # nothing within the laser's reach
if "goal_in_tip.forwards" in place:
    observation[0, place["goal_in_tip.forwards"]] = 0.1  # the target is 0.1 m ahead
    observation[0, place["goal_near.forwards"]] = 0.1 / (0.1 + 0.03)

action, physical = session.run(["action", "physical_action"], {"observation": observation})
print(f"{told['robot']}, {told['task']}, control by {told['control']}, {told['rate_hz']:g} Hz")
for value, share, size in zip(told["action"], action[0], physical[0], strict=True):
    print(f"{value['name']:12} {share:+.3f} of full, {size:+.4f} {value['unit']}")
