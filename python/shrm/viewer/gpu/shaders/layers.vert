// A triangle that covers the picture, once for each layer of the target.
#version 330 core

flat out int layer_of;

void main() {
    layer_of = gl_InstanceID;
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 1.0, 1.0);
}
