#ifndef NDEBUG
#define NDEBUG
#endif
#include <fstream> // which tinygltf uses and leaves out where it has no files

#define TINYGLTF_IMPLEMENTATION
#include "plugin/gltf/TinyGltf.h"
