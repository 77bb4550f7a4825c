"""Policies as files for other programs, ONNX and TorchScript, compared with the original on recorded observations."""
