"""A reflection-mapping shader that knows nothing of this package is given its dynamic map [RH02 section 7.5].

The one below is what any engine has: it looks an environment map up along the mirrored ray. With the map of a
view in place of the environment the same shader draws a glossy surface.
"""

import numpy as np
from shrm import brdf, prefilter
from shrm.environment import Environment
from support import opengl, oracles

SIZE = 96

VERTEX = """
#version 330 core
in vec3 position;  // of a unit sphere, which is its normal
out vec3 normal;
void main() {
    normal = position;
    gl_Position = vec4(position.y, position.z, -position.x, 1.0);  // seen from +x, y to the right
}
"""

FRAGMENT = """
#version 330 core
uniform samplerCube environment_map;
in vec3 normal;
out vec4 color;
void main() {
    vec3 r = reflect(vec3(-1.0, 0.0, 0.0), normalize(normal));
    color = texture(environment_map, vec3(-r.y, r.z, r.x));  // OpenGL's axes: +Z front is +x, +X right is -y
}
"""


def test_a_plain_shader_draws_a_glossy_sphere():
    gl = opengl.context().gl
    rm = prefilter(
        Environment.daylight(size=64),
        brdf.GGX(0.4),
        orders=(10, 3),
        size=64,
        layout="cube",
        center="reflection",
    )
    view = np.array([1.0, 0.0, 0.0])

    # Five lines: the map of a view is an ordinary cube map.
    cube = gl.texture_cube((64, 64), 3, dtype="f4")
    for face, pixels in enumerate(rm.at_view(view)):
        cube.write(face, pixels)
    cube.use(0)

    u, v = np.meshgrid(np.linspace(0, np.pi, 181), np.linspace(0, 2 * np.pi, 361), indexing="ij")
    sphere = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1)
    a, b, c, d = sphere[:-1, :-1], sphere[1:, :-1], sphere[1:, 1:], sphere[:-1, 1:]
    triangles = np.stack([a, b, c, a, c, d], axis=2).astype(np.float32)
    program = gl.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
    target = gl.framebuffer([gl.texture((SIZE, SIZE), 4, dtype="f4")], gl.depth_renderbuffer((SIZE, SIZE)))
    target.use()
    target.clear()
    gl.enable_only(gl.DEPTH_TEST)
    gl.vertex_array(program, [(gl.buffer(triangles.tobytes()), "3f", "position")]).render()
    found = np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(SIZE, SIZE, 4)

    y, z = np.meshgrid((np.arange(SIZE) + 0.5) / SIZE * 2 - 1, (np.arange(SIZE) + 0.5) / SIZE * 2 - 1)
    inside = y**2 + z**2 < 0.97
    y, z = y[inside], z[inside]
    normals = np.stack([np.sqrt(1 - y**2 - z**2), y, z], axis=1)
    expected = rm.radiance(normals, view, interpolation="bilinear")
    # Facets of a degree; look-ups across the edges of faces, where `radiance` stays in their planes.
    assert oracles.relative_rms(found[inside][:, :3], expected) < 5e-3
