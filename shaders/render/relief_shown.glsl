// render/relief_shown.glsl: what a fragment knows of the mesh that it is a part of, where the mesh follows relief.
#ifndef TILTH_RENDER_RELIEF_SHOWN
#define TILTH_RENDER_RELIEF_SHOWN
#ifdef RELIEF_MESH
in float v_relief_m;  // what the mesh shows here of the relief, metres above the coarse ground
float mesh_relief_m() { return v_relief_m; }
#else
float mesh_relief_m() { return 0.0; }
#endif
#endif
