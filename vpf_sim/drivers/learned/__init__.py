"""Drivers that run a learned policy: an ONNX model with a manifest, `model.toml` beside `model.onnx`.

observation -> inputs (picture, state) -> session (onnxruntime) -> command
"""
