// Stands in for SensePlayback where libmidair has no functions for C.
#include "haptics/base/InputError.h"
#include "samples/tools/sense/SensePlayback.h"

namespace midair::samples
{

struct SensePlayback::Scene
{
    Eigen::Matrix4d place;
};

SensePlayback::SensePlayback(const SensePlaybackOptions& /*options*/,
                             std::function<void(const std::string&)> /*tell*/)
{
    throw base::InputError("--play and --serve aren't in this build: it was compiled without "
                           "libmidair's C interface (MIDAIR_C)");
}

SensePlayback::~SensePlayback() = default;
void SensePlayback::setSensation(const std::string& /*sensation*/) {}
void SensePlayback::setParameters(const SenseParameters& /*parameters*/) {}
void SensePlayback::setTransform(const Eigen::Matrix4d& /*transform*/) {}
void SensePlayback::setTracking(bool /*isTracking*/) {}
void SensePlayback::begin() {}
void SensePlayback::end() {}
void SensePlayback::update(double /*time_s*/) {}
void SensePlayback::mute() {}

std::optional<SenseHand> SensePlayback::hand() const
{
    return {};
}

bool SensePlayback::isOpening() const
{
    return false;
}

bool SensePlayback::isOpen() const
{
    return false;
}

bool SensePlayback::isWorking() const
{
    return false;
}

std::string SensePlayback::status() const
{
    return {};
}

const Eigen::Matrix4d& SensePlayback::place() const
{
    return _scene->place;
}

} // namespace midair::samples
