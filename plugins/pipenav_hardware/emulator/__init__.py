"""An arm made of software: servos, scanner and front sensor on pseudo-terminals, in a process of their own.

It answers byte for byte as the devices do, in their time, with faults on request, and it logs every byte with its time.
The driver's safety is judged by that log, not by what the driver believes.
"""
