// The pressure cap holds in each way of playing while a reflector moves: with it where it is now,
// and, as it may be gone, without it. In double precision, from what the device was told to play.
#include "engine-bridge/pipeline/HologramPipeline.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "haptics/sensation/SensationReader.h"
#include "tests/engine-bridge/contact/ContactScenes.h"
#include "tests/engine-bridge/pipeline/Plate.h"
#include "tests/haptics/base/threads/SetClock.h"

#include <algorithm>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

constexpr double kPlateCap_Pa = 300.0;
constexpr double kPlateFrame_s = 1.0 / 60.0;

enum class Way
{
    HELD,
    EVENED,
    CYCLE,
    SUBSETS,
    OUTLINE,
    MODULATION,
    CONTACT,
    SENSATION
};

HologramOptions optionsFor(Way way, const base::Clock& clock)
{
    HologramOptions options;
    options.clock = &clock;
    options.array = haptics::TransducerArray::octagonalPrism();
    options.maxPressure = kPlateCap_Pa;
    if (way != Way::EVENED) options.even = 0;
    if (way == Way::CYCLE) options.cycle = 3;
    if (way == Way::SUBSETS) options.subsets = 3;
    if (way == Way::MODULATION) options.modulation.amplitudeRate_Hz = 10.0;
    if (way == Way::CONTACT) options.contacts.shares.render = Render::CONTACT;
    return options;
}

SceneSnapshot sceneFor(Way way)
{
    SceneSnapshot scene;
    scene.objects = {bridge::test::object(bridge::test::sheet(way == Way::CONTACT ? 30 : 15))};
    scene.objects[0].path = "Scene/Sheet";
    HapticProperties& properties = scene.objects[0].properties;
    if (way == Way::OUTLINE) properties.sampling = haptics::Sampling::EDGES;
    if (way == Way::CONTACT) scene.hands = bridge::test::ball({0.0, 0.0, 6.5e-3});
    if (way != Way::SENSATION) return scene;
    properties.pressure = 1000.0;
    properties.pressureInPa = true;
    properties.sensation.isMeant = true;
    properties.sensation.pattern =
        std::make_shared<const haptics::Sensation>(haptics::loadSensation("circle?radius=20mm"));
    return scene;
}

/// The loudest of \a fields at \a points, with \a reflectors.
double loudest_Pa(const std::vector<Eigen::VectorXcf>& fields,
                  const Eigen::Matrix3Xd& points,
                  const std::vector<haptics::Reflector>& reflectors)
{
    haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    array.reflectors = reflectors;
    const Eigen::MatrixXcd G =
        haptics::referencePropagationMatrix(points, array, haptics::Medium());
    double most_Pa = 0.0;
    for (const Eigen::VectorXcf& q : fields)
        most_Pa = std::max(most_Pa, (G * q.cast<std::complex<double>>()).cwiseAbs().maxCoeff());
    return most_Pa;
}

class ReflectorMatrix : public testing::TestWithParam<Way>
{
};

} // namespace

TEST_P(ReflectorMatrix, TheCapIsKeptWhileOneMoves)
{
    midair::test::SetClock clock;
    HologramPipeline pipeline(optionsFor(GetParam(), clock));
    SceneSnapshot scene = sceneFor(GetParam());
    double most_Pa = 0.0;
    int looks = 0;
    std::shared_ptr<const HologramResult> last;
    std::vector<Eigen::VectorXcf> before;
    const auto look = [&](double y_m)
    {
        // Most fields of contacts have no result, which would say where their points are.
        std::vector<Eigen::VectorXcf> fields = pipeline.device().planned();
        if (!last || last->points.size() == 0 || fields.empty() || fields == before ||
            fields != last->sequence.fields)
            return;
        before = fields;
        ++looks;
        const Eigen::Matrix3Xd& points = last->points.positions;
        const double with_Pa = loudest_Pa(fields, points, {plateAt(y_m).rectangle});
        EXPECT_LE(with_Pa, 1.0005 * kPlateCap_Pa) << y_m;
        EXPECT_LE(loudest_Pa(fields, points, {}), 1.0005 * kPlateCap_Pa) << y_m;
        most_Pa = std::max(most_Pa, with_Pa);
    };
    for (int frame = 0; frame < 10; ++frame)
    {
        // It moves, rests for long enough that fields at rest come, and moves on.
        const double y_m = -0.045 - 2e-3 * std::max(0, std::min(frame, 3) + std::max(0, frame - 6));
        scene.reflectors = {plateAt(y_m)};
        scene.time_s = clock.now_s();
        last = pipeline.process(scene);
        look(y_m);
        const double until_s = clock.now_s() + (frame == 5 ? 0.4 : kPlateFrame_s);
        for (int k = 0; clock.now_s() < until_s && k < 3000; ++k)
        {
            if (auto next = pipeline.attend()) last = std::move(next);
            if (k % 50 == 0) look(y_m);
            clock.jump(std::clamp(pipeline.rest_s(), 1e-4, 1e-3));
        }
    }
    EXPECT_GE(looks, 6);
    EXPECT_GT(most_Pa, 0.6 * kPlateCap_Pa) << "or this shows nothing";
}

INSTANTIATE_TEST_SUITE_P(Ways,
                         ReflectorMatrix,
                         testing::Values(Way::HELD,
                                         Way::EVENED,
                                         Way::CYCLE,
                                         Way::SUBSETS,
                                         Way::OUTLINE,
                                         Way::MODULATION,
                                         Way::CONTACT,
                                         Way::SENSATION));
