"""Shader programs, put together from the files in shaders/."""

from __future__ import annotations

from functools import lru_cache
from importlib.resources import files
from typing import Any, Literal

import moderngl
import numpy as np

Surface = Literal["mesh", "sphere"]
Maps = Literal["dynamic", "factored"]


@lru_cache
def source(name: str) -> str:
    """Text of a shader file."""
    return files("shrm.viewer").joinpath("shaders", name).read_text(encoding="utf-8")


def object_program(gl: moderngl.Context, surface: Surface, maps: Maps) -> moderngl.Program:
    """Return the program that draws one lobe of an object."""
    parts = ("surface.glsl", f"{surface}.glsl", "central_direction.glsl", f"{maps}_map.glsl", "object.frag")
    fragment = "\n".join(["#version 330 core", *map(source, parts)])
    return gl.program(vertex_shader=source(f"{surface}.vert"), fragment_shader=fragment)


def screen_program(gl: moderngl.Context, name: str) -> moderngl.Program:
    """Return a program that fills the picture: its fragments are those of `name`."""
    return gl.program(vertex_shader=source("screen.vert"), fragment_shader=source(name))


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
