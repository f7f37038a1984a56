"""Packs the module, its library and its data into a wheel, which is a zip with three files of metadata. Neither pip nor setuptools is
needed. The wheel is for this version of Python and for this system, whose libraries (libusb, libstdc++ ..) it needs."""

import argparse
import base64
import hashlib
import pathlib
import sysconfig
import zipfile


def tag():
    version = sysconfig.get_config_var("py_version_nodot")
    return f"cp{version}-cp{version}-" + sysconfig.get_platform().replace("-", "_").replace(".", "_")


def files_of(args, info):
    """Name in the wheel and content of each file."""
    here = pathlib.Path(__file__).parent
    for source in (args.module, here / "__init__.pyi", here / "py.typed"):
        yield f"midair/{source.name}", source.read_bytes()
    # As below a prefix: the library finds its data beside itself.
    yield f"midair/{args.library_name}", args.library.read_bytes()
    for name, folder in (("arrays", "haptics/array/arrays"), ("materials", "engine-bridge/materials")):
        for source in sorted((args.root / folder).glob("*.json")):
            yield f"midair/{args.data}/{name}/{source.name}", source.read_bytes()
    yield f"{info}/LICENSE", (args.root / "LICENSE").read_bytes()
    version = sysconfig.get_python_version()
    yield f"{info}/METADATA", (
        f"Metadata-Version: 2.1\nName: midair\nVersion: {args.version}\nSummary: touch in mid-air by ultrasound\n"
        f"Requires-Python: =={version}.*\nRequires-Dist: numpy\nLicense-File: LICENSE\n").encode()
    yield f"{info}/WHEEL", f"Wheel-Version: 1.0\nGenerator: osgMidair\nRoot-Is-Purelib: false\nTag: {tag()}\n".encode()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("out", "module", "library", "root"):
        parser.add_argument(f"--{name}", type=pathlib.Path, required=True)
    parser.add_argument("--version", required=True)
    parser.add_argument("--as", dest="library_name", required=True, help="the library's place in the package")
    parser.add_argument("--data", required=True, help="the data's place in the package")
    args = parser.parse_args()
    args.out.mkdir(parents=True, exist_ok=True)
    for old in args.out.glob("midair-*.whl"):
        old.unlink()
    info = f"midair-{args.version}.dist-info"
    record = ""
    with zipfile.ZipFile(args.out / f"midair-{args.version}-{tag()}.whl", "w", zipfile.ZIP_DEFLATED) as wheel:

        def write(name, content):
            entry = zipfile.ZipInfo(name)  # of 1980: the same files give the same wheel
            entry.external_attr = (0o755 if ".so" in name else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, content)

        for name, content in files_of(args, info):
            digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
            record += f"{name},sha256={digest},{len(content)}\n"
            write(name, content)
        write(f"{info}/RECORD", record + f"{info}/RECORD,,\n")


if __name__ == "__main__":
    main()
