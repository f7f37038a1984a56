// Replaces TagDetector.cpp in builds without libapriltag: reports that tags are not available.

#include "engine-bridge/tags/TagDetector.h"
#include "haptics/base/InputError.h"

namespace midair::bridge
{

struct TagDetector::Library
{
};

TagDetector::TagDetector()
{
    throw base::InputError("AprilTag is not in this build; configure it with -DMIDAIR_APRILTAG=ON");
}

TagDetector::~TagDetector() = default;

std::vector<TagSeen> TagDetector::detect(const GrayImage& /*image*/)
{
    return {};
}

GrayImage TagDetector::bitmap(int /*id*/) const
{
    return {};
}

} // namespace midair::bridge
