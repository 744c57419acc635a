// The GL loader's code. Its two functions are renamed by tilth_glad's compile definitions (cmake/TilthGl.cmake).
#include <gl.c>  // NOLINT(bugprone-suspicious-include): it is to be compiled here
