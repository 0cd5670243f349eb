#!/usr/bin/env python3
"""Two logs of a chirp on the roll axis of a simulated quadcopter, as two autopilots write them.

    chirp_logs.py [FOLDER]

copter.bin     ArduPilot's DataFlash: mode System ID with the mixer's roll input excited (SID_AXIS 10): SIDS, SIDD, RATE
blackbox.csv   Betaflight's Blackbox, decoded: the chirp is in setpoint[0]

    roll rate, deg/s, per mixer input:   60000 e^(-0.0125 s) / ((s + 4) (s + 20)),   behind a PI rate loop at 400 Hz

Turbulence acts where the mixer acts, so feedback brings it into the mixer's input. The gyro is noisy.
"""

import math
import random
import struct
import sys
from pathlib import Path

RATE, SECONDS = 400, 60
DELAY = 5  # samples: 12.5 ms
LOW, HIGH = 0.3, 20.0  # Hz
POLES, RESIDUE = (4.0, 20.0), 60000.0 / 16.0
P, I = 0.004, 0.02


def chirp(t: float) -> float:
    """Of magnitude 1; its frequency rises by the same factor each second."""
    rate = math.log(HIGH / LOW) / SECONDS
    return math.sin(2.0 * math.pi * LOW / rate * (math.exp(rate * t) - 1.0))


def fly(to_mixer: float, to_setpoint: float, seed: int):
    """Samples of time, chirp, setpoint, mixer input, roll rate."""
    noise = random.Random(seed)
    through = [math.exp(-pole / RATE) for pole in POLES]
    lags = [0.0, 0.0]
    pipe = [0.0] * DELAY
    turbulence = integral = 0.0
    for k in range(RATE * SECONDS):
        t = k / RATE
        gyro = lags[0] - lags[1] + noise.gauss(0.0, 1.0)
        excitation = chirp(t)
        setpoint = to_setpoint * excitation
        error = setpoint - gyro
        integral += error / RATE
        mixer = P * error + I * integral + to_mixer * excitation
        yield t, to_mixer * excitation, setpoint, mixer, gyro
        pipe.append(mixer)
        turbulence = 0.99 * turbulence + 0.0008 * noise.gauss(0.0, 1.0)
        driven = pipe.pop(0) + turbulence
        for i, pole in enumerate(POLES):
            lags[i] = through[i] * lags[i] + (1.0 - through[i]) * RESIDUE / pole * driven


def dataflash(samples) -> bytes:
    """A log that describes its own messages, as AP_Logger writes it."""
    messages = {
        "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
        "SIDS": (1, "QBfffffff", "TimeUS,Ax,Mag,FSt,FSp,TFin,TC,TR,TFout"),
        "SIDD": (2, "Qfffffffff", "TimeUS,Time,Targ,F,Gx,Gy,Gz,Ax,Ay,Az"),
        "RATE": (3, "Qffffffffffff", "TimeUS,RDes,R,ROut,PDes,P,POut,YDes,Y,YOut,ADes,A,AOut"),
    }
    packed = {letter: "<" + {"n": "4s", "N": "16s", "Z": "64s"}.get(letter, letter) for letter in "QBfnNZ"}

    def size(form: str) -> int:
        return 3 + sum(struct.calcsize(packed[letter]) for letter in form)

    def message(name: str, *values) -> bytes:
        number, form, _ = messages[name]
        return b"\xa3\x95" + bytes([number]) + b"".join(struct.pack(packed[c], v) for c, v in zip(form, values))

    log = [
        message("FMT", number, size(form), name.encode(), form.encode(), columns.encode())
        for name, (number, form, columns) in messages.items()
    ]
    log.append(message("SIDS", 10_000_000, 10, 0.1, LOW, HIGH, 0.0, 0.0, SECONDS, 0.0))
    for t, excitation, setpoint, mixer, gyro in samples:
        now = 10_000_000 + round(t * 1e6)
        frequency = LOW * (HIGH / LOW) ** (t / SECONDS)
        log.append(message("SIDD", now, t, excitation, frequency, gyro, 0.0, 0.0, 0.0, 0.0, -9.81))
        log.append(message("RATE", now, setpoint, gyro, mixer, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    return b"".join(log)


def blackbox(samples) -> str:
    """As blackbox_decode writes it, a part of its columns."""
    rows = ["loopIteration, time (us), setpoint[0], gyroADC[0]"]
    for k, (t, _, setpoint, _, gyro) in enumerate(samples):
        rows.append(f"{k}, {round(t * 1e6)}, {setpoint:.0f}, {gyro:.0f}")
    return "\n".join(rows) + "\n"


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
    (folder / "copter.bin").write_bytes(dataflash(fly(0.1, 0.0, seed=1)))
    (folder / "blackbox.csv").write_text(blackbox(fly(0.0, 100.0, seed=2)))


if __name__ == "__main__":
    main()
