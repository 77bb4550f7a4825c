"""The hardware backend: an arm of AX-12A servos with its range sensors, and an emulator of them."""

from pipenav_hardware.backend import HardwareBackend

__all__ = ["HardwareBackend"]
