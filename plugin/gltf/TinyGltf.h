#pragma once

// tinygltf only parses JSON into structures and decodes base64: OSG reads images, GltfFile reads
// files, and GltfNumbers checks all references. It is compiled into the kit (TinyGltf.cpp) without
// assertions; those enabled in Debian's library would end the program. Debian's other reader,
// assimp, has fifty formats in one library, lets the file choose the reader, and keeps neither the
// extras of nodes nor sparse accessors.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_FS

#include <tiny_gltf.h>
