"""Shader programs, put together from the files in shaders/."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files
from typing import Any, Literal

import moderngl
import numpy as np

from shrm.prefiltered.icosahedron import coordinates, faces, icosahedron

Surface = Literal["mesh", "tangent_mesh", "sphere"]
Maps = Literal["dynamic", "factored", "layered", "paraboloid"]


@lru_cache
def source(name: str) -> str:
    """Text of a shader file."""
    return files("shrm.viewer.gpu").joinpath("shaders", name).read_text(encoding="utf-8")


def object_program(gl: moderngl.Context, surface: Surface, maps: Maps) -> moderngl.Program:
    """Return the program that draws one lobe of an object."""
    basis = {"dynamic": (), "paraboloid": ("paraboloid.glsl",)}.get(maps, ("bordered_maps.glsl",))
    looked_up = ("central_direction.glsl", *basis, f"{maps}_map.glsl")
    shape = "sphere" if surface == "sphere" else "mesh"
    parts = ("surface.glsl", f"{shape}.glsl", *looked_up, "object.frag")
    head = ["#version 330 core", *(["#define TANGENTS"] if surface == "tangent_mesh" else [])]
    program = gl.program(
        vertex_shader="\n".join([*head, source(f"{shape}.vert")]),
        fragment_shader="\n".join([*head, *map(source, parts)]),
    )
    if maps == "layered":
        set_arrays(program, vertices=icosahedron(), faces=faces(), coordinates=coordinates())
    return program


def vertex_radiance_program(gl: moderngl.Context) -> moderngl.Program:
    """Return the program that draws a mesh with radiance at its vertices."""
    return gl.program(
        vertex_shader=source("vertex_radiance.vert"), fragment_shader=source("vertex_radiance.frag")
    )


def screen_program(gl: moderngl.Context, name: str) -> moderngl.Program:
    """Return a program that fills the picture: its fragments are those of `name`."""
    return gl.program(vertex_shader=source("screen.vert"), fragment_shader=source(name))


def layers_program(gl: moderngl.Context, *parts: str) -> moderngl.Program:
    """Return a program that fills all layers of a target: its fragments are those of the parts together."""
    fragment = "\n".join(["#version 330 core", *map(source, parts)])
    return gl.program(
        vertex_shader=source("layers.vert"), geometry_shader=source("layers.geom"), fragment_shader=fragment
    )


def set_arrays(program: moderngl.Program, **values: np.ndarray) -> None:
    """Set uniforms that are arrays of vectors, or of matrices column by column."""
    for name, value in values.items():
        uniform = program[name]
        assert isinstance(uniform, moderngl.Uniform)
        kind = np.int32 if np.issubdtype(value.dtype, np.integer) else np.float32
        uniform.write(np.ascontiguousarray(value, kind).tobytes())


def set_uniforms(program: moderngl.Program, **values: Any) -> None:
    """Set uniforms; those that a program has no use for are left out by its compiler, and here."""
    for name, value in values.items():
        uniform = program.get(name, None)
        if not isinstance(uniform, moderngl.Uniform):
            continue
        if isinstance(value, np.ndarray):  # OpenGL's matrices are stored column by column
            uniform.write(np.ascontiguousarray(value.T, np.float32).tobytes())
        else:
            uniform.value = value
