"""Builds a package of messages, as `ros2/meniscus_msgs`, for Python with ROS's own generators, as colcon would with `rosidl_generate_interfaces`.

usage: build_messages.py PACKAGE OUT

OUT gets the Python package and its libraries; PYTHONPATH has to name OUT, LD_LIBRARY_PATH the package's folder in it. The generators, headers and libraries are those of the pip
packages beside this interpreter.
"""

import json
import pathlib
import subprocess
import sys
import sysconfig

import numpy
import rosidl_generator_c
import rosidl_generator_py
import rosidl_generator_type_description
import rosidl_typesupport_c
import rosidl_typesupport_fastrtps_c
import rosidl_typesupport_introspection_c
from rosidl_adapter.msg import convert_msg_to_idl
from rosidl_adapter.srv import convert_srv_to_idl

NAME = pathlib.Path(sys.argv[1]).resolve().name
NEEDED = ["std_msgs", "geometry_msgs", "builtin_interfaces", "service_msgs"]
PREFIX = pathlib.Path(sys.prefix)
SUPPORTS = ["rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c"]


def generate(package: pathlib.Path, out: pathlib.Path, work: pathlib.Path) -> list[pathlib.Path]:
    """Writes the Python package of the interfaces in `package` to `out` and the C sources below `work`. Returns the folders
    with headers."""
    files = sorted(package.glob("msg/*.msg")) + sorted(package.glob("srv/*.srv"))
    interfaces = work / "interfaces"
    for file in files:
        convert = convert_msg_to_idl if file.suffix == ".msg" else convert_srv_to_idl
        relative = file.relative_to(package)
        (interfaces / relative.parent).mkdir(parents=True, exist_ok=True)
        convert(package, NAME, relative, interfaces / relative.parent)
    idl = [file.relative_to(package).with_suffix(".idl") for file in files]
    common = {
        "package_name": NAME,
        "idl_tuples": [f"{interfaces}:{path}" for path in idl],
        "ros_interface_files": [str(file) for file in files],
        "ros_interface_dependencies": [],
        "include_paths": [f"{name}:{PREFIX}/share/{name}" for name in NEEDED],
        "type_description_tuples": [f"{path}:{interfaces}/{path.with_suffix('.json')}" for path in idl],
        "target_dependencies": [],
    }

    def run(generator: str, function, to: pathlib.Path, *more) -> pathlib.Path:
        """Runs a generator of ROS into a folder of its own, and returns the folder."""
        resources = PREFIX / "share" / generator / "resource"
        for kind in ["msg", "srv"]:
            (to / kind / "detail").mkdir(parents=True, exist_ok=True)
        path = work / f"{generator}.json"
        path.write_text(json.dumps(common | {"template_dir": str(resources), "output_dir": str(to)}), encoding="utf-8")
        function(str(path), *more)
        template = resources / f"{generator}__visibility_control.h.in"
        if template.exists():
            text = template.read_text(encoding="utf-8")
            text = text.replace("@PROJECT_NAME@", NAME).replace("@PROJECT_NAME_UPPER@", NAME.upper())
            (to / "msg" / f"{generator}__visibility_control.h").write_text(text, encoding="utf-8")
        return to.parent

    description = rosidl_generator_type_description.generate_type_hash
    run("rosidl_generator_type_description", description, interfaces)
    run("rosidl_generator_py", rosidl_generator_py.generate_py, out, ["rosidl_typesupport_c", *SUPPORTS])
    fastrtps, introspection = SUPPORTS
    return [
        run("rosidl_generator_c", rosidl_generator_c.generate_c, work / "c" / NAME),
        run("rosidl_typesupport_c", rosidl_typesupport_c.generate_c, work / "support" / NAME, SUPPORTS),
        run(fastrtps, rosidl_typesupport_fastrtps_c.generate_typesupport_fastrtps_c, work / "fastrtps" / NAME),
        run(introspection, rosidl_typesupport_introspection_c.generate_c, work / "introspection" / NAME),
    ]


def compile_all(out: pathlib.Path, headers: list[pathlib.Path]) -> None:
    """Compiles the sources below `headers` and in `out` to one library, and the package's entry points beside it."""
    includes = [*headers, PREFIX / "include", sysconfig.get_paths()["include"], numpy.get_include()]
    includes += [folder for folder in (PREFIX / "include").iterdir() if folder.is_dir()]
    flags = [*[f"-I{folder}" for folder in includes], "-O0", "-fPIC", "-w"]
    libraries = [f"-L{PREFIX}/lib", f"-L{out}", f"-Wl,-rpath,{out}:{PREFIX}/lib", "-lrosidl_runtime_c", "-lrcutils"]
    libraries += ["-lrosidl_typesupport_c", *[f"-l{support}" for support in SUPPORTS], "-lrosidl_typesupport_fastrtps_cpp"]
    kinds = ["generator_c", "typesupport_c", "typesupport_fastrtps_c", "typesupport_introspection_c", "generator_py"]
    for name in NEEDED:
        libraries += [f"-l{name}__rosidl_{kind}" for kind in kinds if (PREFIX / f"lib/lib{name}__rosidl_{kind}.so").exists()]
    libraries.append("-l:libfastcdr.so.2")
    compiling, objects = [], headers[0].parent / "objects"
    for number, folder in enumerate([*headers, out / "msg", out / "srv"]):
        for kind, compiler in [("c", ["cc"]), ("cpp", ["c++", "-std=c++17"])]:
            # Sources of two generators may have one name.
            sources, made = [str(path) for path in folder.rglob(f"*.{kind}")], objects / f"{number}{kind}"
            made.mkdir(parents=True, exist_ok=True)
            if sources:
                compiling.append(subprocess.Popen([*compiler, *flags, "-c", *sources], cwd=made))
    if any([compiler.wait() for compiler in compiling]):
        sys.exit("the generated sources do not compile")
    objects = [str(path) for path in objects.rglob("*.o")]
    subprocess.run(["c++", "-shared", *objects, "-o", str(out / f"lib{NAME}.so"), *libraries], check=True)
    for support in SUPPORTS:
        # The dispatcher looks for these names along LD_LIBRARY_PATH.
        (out / f"lib{NAME}__{support}.so").symlink_to(f"lib{NAME}.so")
    for support in ["rosidl_typesupport_c", *SUPPORTS]:
        entry, made = out / f"_{NAME}_s.ep.{support}.c", out / f"{NAME}_s__{support}.so"
        subprocess.run(["cc", "-shared", *flags, str(entry), "-o", str(made), f"-L{out}", f"-l{NAME}", *libraries], check=True)


def main() -> None:
    """Builds the package in the first argument into the second."""
    package, parent = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    out, work = parent / NAME, parent / f"work-{NAME}"
    out.mkdir(parents=True, exist_ok=True)
    work.mkdir(exist_ok=True)
    headers = generate(package, out, work)
    (out / "__init__.py").touch()
    compile_all(out, headers)


if __name__ == "__main__":
    main()
