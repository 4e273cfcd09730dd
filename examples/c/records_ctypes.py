"""Load distribution of two bodies from files of `flankload record`, by handles through ctypes.

flankload record SCENE -o FOLDER
python records_ctypes.py LIBRARY FOLDER

LIBRARY is libflankload.so. Prints for each torque and position status and rotation.
"""

import ctypes
import sys
from pathlib import Path


def loaded(library):
    """The library with the types of what its procedures return: handles are pointers."""
    core = ctypes.CDLL(library)
    for name in ("new_error", "read_body", "read_mesh", "new_problem", "solve"):
        getattr(core, f"flankload_{name}").restype = ctypes.c_void_p
    return core


def main(library, folder):
    core = loaded(library)
    error = ctypes.c_void_p(core.flankload_new_error())

    def call(name, *arguments):
        """Call a procedure, and raise its error."""
        found = getattr(core, f"flankload_{name}")(error, *arguments)
        if core.flankload_check_error(error):
            text = ctypes.create_string_buffer(200)
            core.flankload_get_error(error, text, 200)
            sys.exit(text.value.decode())
        return found

    def path(name):
        return bytes(next(Path(folder).glob(f"{name}.*"), Path(folder) / name))

    problem = ctypes.c_void_p(call("new_problem"))
    for name in ("body_1", "body_2"):
        body = ctypes.c_void_p(call("read_body", path(name)))
        call("add_body", problem, body)
        core.flankload_delete_body(ctypes.byref(body))
    mesh = ctypes.c_void_p(call("read_mesh", path("mesh")))
    call("add_mesh", problem, mesh)
    call("read_motion", problem, path("motion"))
    result = ctypes.c_void_p(call("solve", problem))
    sizes = [ctypes.c_int() for _ in range(5)]
    call("get_sizes", result, *(ctypes.byref(size) for size in sizes))
    positions, torques = (size.value for size in sizes[:2])
    status = (ctypes.c_int * (positions * torques))()
    rotation = (ctypes.c_double * (positions * torques))()
    call("get_status", result, status)
    call("get_motion", result, rotation)
    for t in range(torques):
        print("torque", t + 1)
        for k in range(positions):
            state = k + t * positions
            print(k + 1, status[state], f"{rotation[state]:.13e}")
    for handle, name in ((result, "result"), (problem, "problem"), (mesh, "mesh")):
        getattr(core, f"flankload_delete_{name}")(ctypes.byref(handle))
    core.flankload_delete_error(ctypes.byref(error))


if __name__ == "__main__":
    main(*sys.argv[1:])
