"""Policies that were trained elsewhere take a seat: files of ONNX, TorchScript, Stable-Baselines3 and LeRobot."""
