"""Continues runs of an FMU for co-simulation from serialized states, in a process of its own.

    continue_fmu.py LIBRARY TOKEN VERSION STEP INPUTS OUTPUTS < cases

INPUTS and OUTPUTS: value references, commas between. A case is a line: the state in hexadecimal digits, its time, then
the inputs of each step, all as hexadecimal numbers. Prints all outputs after each step, a row each."""
import ctypes
import sys
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_uint32, c_void_p

library, token, version = ctypes.CDLL(sys.argv[1]), sys.argv[2].encode(), sys.argv[3]
step = float.fromhex(sys.argv[4])
inputs, outputs = ([int(r) for r in text.split(",")] for text in sys.argv[5:7])
three = version == "3"
prefix = "fmi" + version


def call(name, *arguments):
    status = getattr(library, prefix + name)(*arguments)
    if status != 0:
        sys.exit(f"{name} returns {status}")


if three:
    instantiate = library.fmi3InstantiateCoSimulation
    instantiate.argtypes = [c_char_p] * 3 + [c_bool] * 4 + [c_void_p, c_size_t, c_void_p, c_void_p, c_void_p]
    instantiate.restype = c_void_p
    instance = instantiate(b"elsewhere", token, None, False, False, False, False, None, 0, None, None, None)
else:
    instantiate = library.fmi2Instantiate
    instantiate.argtypes = [c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int]
    instantiate.restype = c_void_p
    instance = instantiate(b"elsewhere", 1, token, b"", None, 0, 0)
if not instance:
    sys.exit("no instance")
component = c_void_p(instance)


def numbers(references, values):
    """What Get and Set of either version take behind the component."""
    count = c_size_t(len(references))
    arguments = [(c_uint32 * len(references))(*references), count, values]
    return arguments + [count] if three else arguments


number = "Float64" if three else "Real"
for line in sys.stdin:
    words = line.split()
    data, time = bytes.fromhex(words[0]), float.fromhex(words[1])
    state = c_void_p()
    call("DeserializeFMUState" if three else "DeSerializeFMUstate", component, data, c_size_t(len(data)), byref(state))
    call("SetFMUState" if three else "SetFMUstate", component, state)
    call("FreeFMUState" if three else "FreeFMUstate", component, byref(state))
    given = [float.fromhex(word) for word in words[2:]]
    for first in range(0, len(given), len(inputs)):
        values = (c_double * len(inputs))(*given[first:first + len(inputs)])
        call("Set" + number, *([component] + numbers(inputs, values)))
        if three:
            flags, last = (c_bool * 3)(), c_double()
            at = [ctypes.cast(ctypes.addressof(flags) + i, POINTER(c_bool)) for i in range(3)]
            call("DoStep", component, c_double(time), c_double(step), True, *at, byref(last))
        else:
            call("DoStep", component, c_double(time), c_double(step), 1)
        time += step
        row = (c_double * len(outputs))()
        call("Get" + number, *([component] + numbers(outputs, row)))
        print("row", *[value.hex() for value in row])
