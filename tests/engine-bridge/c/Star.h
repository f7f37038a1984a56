#pragma once

#include "tests/engine-bridge/c/Opened.h"

#include <string>

/// Adds the samples' star to a scene.
inline midair_object addStar(midair_scene* scene)
{
    midair_object star = 0;
    const std::string file = std::string(MIDAIR_ROOT) + "/samples/models/star.obj";
    EXPECT_EQ(midair_add_file(scene, file.c_str(), 0.08, &star), MIDAIR_OK) << midair_last_error();
    return star;
}
