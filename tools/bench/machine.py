"""What the figures were measured on: no names of hosts."""
import os
import platform
import re
import subprocess


def output(*command):
    try:
        return subprocess.run(command, capture_output=True, text=True).stdout
    except OSError:
        return ""


def compiler(folder):
    """That of the build which this folder belongs to, as it names itself."""
    found = next(f for p in folder.resolve().parents for f in p.glob("CMakeFiles/*/CMakeCXXCompiler.cmake"))
    command = re.search(r'^set\(CMAKE_CXX_COMPILER "(.*)"\)', found.read_text(), re.MULTILINE)[1]
    return (output(command, "--version").splitlines() or ["?"])[0]


def describe(folder):
    fields = dict(re.findall(r"^([^:\n]+):\s+(.+)$", output("lscpu"), re.MULTILINE))
    flags = fields.get("Flags", "").split()
    vectors = next((name for flag, name in (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("avx", "AVX")) if flag in flags),
                   "SSE2")
    release = re.search(r'PRETTY_NAME="(.+)"', open("/etc/os-release").read()) if os.path.exists("/etc/os-release") \
        else None
    return {
        "processor": fields.get("Model name", platform.processor()),
        "family": f"{fields.get('Vendor ID', '')} family {fields.get('CPU family', '?')} model {fields.get('Model', '?')}",
        "cores": int(fields.get("CPU(s)", os.cpu_count() or 1)),
        "virtual": fields.get("Hypervisor vendor", ""),
        "vectors": vectors,
        "L1d": fields.get("L1d cache", "?"), "L2": fields.get("L2 cache", "?"), "L3": fields.get("L3 cache", "?"),
        "kernel": platform.release(),
        "system": release[1] if release else platform.system(),
        "compiler": compiler(folder),
        "load_at_start": round(os.getloadavg()[0], 2),
    }


def sentence(machine):
    kind = f"virtual machine ({machine['virtual']})" if machine["virtual"] else "machine"
    return (f"{machine['cores']}-core {kind}, {machine['processor']} ({machine['family']}), {machine['vectors']}; caches "
            f"L1d {machine['L1d']}, L2 {machine['L2']}, L3 {machine['L3']}; {machine['system']}, {machine['compiler']}; "
            f"load {machine['load_at_start']} when it began.")
