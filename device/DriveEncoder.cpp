#include "device/DriveEncoder.h"

#include <cmath>

namespace midair::device
{

const std::vector<float>& amplitudeLevels()
{
    static const std::vector<float> kLevels = [] {
        std::vector<float> levels(256);
        for (int level = 0; level < 256; ++level)
            levels[level] = static_cast<float>(std::sin(M_PI * level / 510.0));
        return levels;
    }();
    return kLevels;
}

} // namespace midair::device
