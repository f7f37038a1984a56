#include "engine-bridge/rendering/ContactRenderer.h"

#include "haptics/base/InputError.h"
#include "haptics/sequence/Modulator.h"
#include "tests/engine-bridge/contact/ContactScenes.h"

#include <cmath>

#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;
using namespace midair::bridge::test;
using Eigen::Vector3d;

namespace
{

const haptics::TransducerArray& octagon()
{
    static const haptics::TransducerArray array = haptics::TransducerArray::octagonalPrism();
    return array;
}

/// Two sheets, one for contacts and one that is whole, \a apart_m from each other.
std::vector<HapticObject> twoSheets(double apart_m = 0.06)
{
    std::vector<HapticObject> objects{object(sheet(), 1), object(sheet(10), 2)};
    objects[0].properties.render = Render::CONTACT;
    objects[1].pose.translation().z() = -apart_m;
    return objects;
}

/// A cycle of two fields of one amplitude with other phases.
haptics::FieldSequence cycleOfTwo(float amplitude)
{
    haptics::FieldSequence sequence;
    const std::complex<float> values[] = {{amplitude, 0.0f}, {0.0f, amplitude}};
    for (const std::complex<float>& value : values)
        sequence.fields.emplace_back(Eigen::VectorXcf::Constant(octagon().size(), value));
    sequence.modulation.fieldRate_Hz = 100.0;
    return sequence;
}

} // namespace

TEST(ContactRenderer, SharesSayWhatIsSolvedForAsAWhole)
{
    ContactRenderer renderer(octagon(), {});
    std::vector<HapticObject> objects = twoSheets();
    EXPECT_TRUE(renderer.concerns(objects));
    renderer.update(objects, {}, 1.0, 0.0);
    EXPECT_EQ(objects[0].share, 0.0);
    EXPECT_EQ(objects[1].share, 1.0);
    EXPECT_FALSE(renderer.isActive(1.0));
    renderer.update(objects, ball(Vector3d(0, 0, 6.5e-3)), 1.01, 0.0);
    EXPECT_TRUE(renderer.isActive(1.01));
    EXPECT_FALSE(renderer.isActive(1.02 + ContactRenderer::kStale_s));
}

// What is whole is heard as a cycle at its own rate, and nothing gets louder than the array is.
TEST(ContactRenderer, FieldsInTurnGoOnBeneathTheFoci)
{
    ContactRenderer renderer(octagon(), {});
    std::vector<HapticObject> objects = twoSheets();
    renderer.update(objects, {}, 1.0, 0.0);
    const haptics::FieldSequence whole = cycleOfTwo(0.5f);
    int ofFirst = 0;
    for (int i = 0; i < 100; ++i)
    {
        const RenderedField field = renderer.render(1.0 + 1e-3 * i, whole);
        ASSERT_FALSE(field.isFailed);
        ASSERT_EQ(field.foci.size(), 0);
        ASSERT_NEAR(std::abs(field.q[0]), 0.5f, 1e-6f);
        ofFirst += field.q[0].real() > 0.4f ? 1 : 0;
    }
    EXPECT_NEAR(ofFirst, 50, 1);

    const haptics::FieldSequence loud = cycleOfTwo(1.0f);
    for (int i = 0; i < 100; ++i)
    {
        const double now_s = 1.1 + 1e-3 * i;
        if (i % 10 == 0) renderer.update(objects, ball(Vector3d(0, 0, 6.5e-3)), now_s, 0.0);
        const RenderedField field = renderer.render(now_s, loud);
        ASSERT_LE(field.q.cwiseAbs().maxCoeff(), 1.0f + 1e-6f);
        ASSERT_TRUE(field.q.allFinite());
        if (i < 20) continue;
        ASSERT_GT(field.foci.size(), 0);
        ASSERT_EQ(field.foci.object, std::vector<int>(field.foci.object.size(), 0));
    }
}

TEST(ContactRenderer, TheLastFiftyMillisecondsAreKept)
{
    ContactRenderer renderer(octagon(), {});
    std::vector<HapticObject> objects = twoSheets();
    renderer.update(objects, ball(Vector3d(0, 0, 6.5e-3)), 1.0, 0.0);
    for (int i = 0; i < 200; ++i)
    {
        const double now_s = 1.0 + 1e-3 * i;
        RenderedField field = renderer.render(now_s, {});
        renderer.keep(now_s, std::move(field.q));
    }
    const ContactScene scene = renderer.view();
    ASSERT_NEAR(static_cast<double>(scene.recent.size()), 51.0, 1.0);
    EXPECT_NEAR(scene.recent.back()->time_s - scene.recent.front()->time_s, 0.05, 1.1e-3);
    ASSERT_EQ(scene.contacts.size(), 1u);
    EXPECT_GT(scene.contacts[0].foci.cols(), 0);
    EXPECT_EQ(scene.contacts[0].pressure_Pa.size(), scene.contacts[0].foci.cols());
    EXPECT_EQ(scene.contacts[0].share, 1.0);
    EXPECT_EQ(scene.whole, 1.0); // of the sheet that is whole
    renderer.clear();
    EXPECT_FALSE(renderer.isActive(1.2));
    EXPECT_TRUE(renderer.view().contacts.empty());
}

TEST(ContactRenderer, ATimeThatRunsBackALittleIsNoJump)
{
    ContactRenderer renderer(octagon(), {});
    std::vector<HapticObject> objects = twoSheets();
    const HandFrame hand = ball(Vector3d(0, 0, 6.5e-3));
    renderer.update(objects, hand, 1.0, 0.0);
    const std::uint64_t id = renderer.view().contacts.at(0).id;
    renderer.update(objects, hand, 0.995, 0.0);
    EXPECT_EQ(renderer.view().contacts.at(0).id, id);
    EXPECT_TRUE(renderer.problems().empty());
}

TEST(ContactRenderer, SettingsOutOfRangeAreNamed)
{
    ContactRendererOptions options;
    options.field.maskCosine = 2.0;
    std::string error;
    EXPECT_FALSE(options.isValid(&error));
    EXPECT_NE(error.find("maskCosine"), std::string::npos) << error;
    EXPECT_THROW(ContactRenderer(octagon(), {}, options), base::InputError);
}
