#pragma once

// tinygltf reads JSON into structures and decodes base64, and no more: images are OSG's, files are
// read by GltfFile, and what numbers refer to is checked by GltfNumbers. It is compiled into the
// kit (TinyGltf.cpp), with the assertions off that Debian's library has on: they would end the
// program. Of Debian's other reader, assimp, fifty formats are one library, whose readers the file
// may choose, and it keeps neither the extras of nodes as they are nor sparse accessors.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_FS

#include <tiny_gltf.h>
