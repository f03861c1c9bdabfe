// Sends each triangle to its layer.
#version 330 core

layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

flat in int layer_of[];

flat out int layer;

void main() {
    for (int k = 0; k < 3; ++k) {
        gl_Layer = layer = layer_of[0];
        gl_Position = gl_in[k].gl_Position;
        EmitVertex();
    }
    EndPrimitive();
}
