// Objects that are one focus: in other units, most often.
#include "engine-bridge/pipeline/PointAssembler.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/engine-bridge/pipeline/Fakes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

using namespace midair;
using namespace midair::bridge;

namespace
{

struct SmallObject : testing::Test
{
    SmallObject()
    {
        PointAssembler::Options options;
        options.wavelength_m = 8.58e-3;
        assembler = std::make_unique<PointAssembler>(array, options, messages);
    }

    /// The square as large as \a size_m, facing the board.
    static SceneSnapshot square(double size_m, std::uint64_t meshId = 7)
    {
        SceneSnapshot snapshot = squareSnapshot();
        HapticObject& object = snapshot.objects[0];
        object.path = "Scene/square";
        object.pose.translation().z() = 0.15;
        object.mesh = std::make_shared<haptics::TriangleMesh>(object.mesh->scaledTo(size_m));
        object.meshId = meshId;
        return snapshot;
    }

    int asked(const std::string& text = "Scene/square: is ") const
    {
        int count = 0;
        for (const base::Message& message : messages.messages())
            if (message.code == base::MessageCode::OBJECT_SMALL)
                count += message.text.rfind(text, 0) == 0 ? 1 : 0;
        return count;
    }

    /// What one focus reaches there.
    double focus_Pa(const haptics::ControlPoints& points) const
    {
        return haptics::referencePropagationMatrix(points.positions, array, haptics::Medium())
            .cwiseAbs()
            .sum();
    }

    haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    base::MessageLog messages;
    std::unique_ptr<PointAssembler> assembler;
};

} // namespace

TEST_F(SmallObject, IsAskedAboutOnceWithTheSizeThatFits)
{
    SceneSnapshot snapshot = square(4e-5);
    snapshot.metresPerUnit = 0.5;
    for (int frame = 0; frame < 3; ++frame)
        assembler->assemble(snapshot);
    ASSERT_EQ(asked(), 1);
    EXPECT_EQ(messages.messages()[0].text,
              "Scene/square: is 4e-05 m wide, under half a wavelength (0.0043 m): it is one focus, "
              "and no louder than one point of something larger; size=0.08 fits");
    assembler->assemble(square(0.0044, 8));
    assembler->assemble(square(0.04, 9));
    EXPECT_EQ(messages.messages().size(), 1u);
}

TEST_F(SmallObject, InMetresThatIsTakenForMillimetresIsAskedAbout)
{
    SceneSnapshot snapshot = square(8e-5);
    snapshot.metresPerUnit = 1e-3;
    assembler->assemble(snapshot);
    ASSERT_EQ(asked(), 1);
    EXPECT_NE(
        messages.messages()[0].text.find("larger; should metresPerUnit be 1 (metres), not 0.001?"),
        std::string::npos)
        << messages.messages()[0].text;
}

TEST_F(SmallObject, IsNoLouderThanAPointOfTheWhole)
{
    for (const double size_m : {4e-5, 1e-3, 0.004})
    {
        const haptics::ControlPoints points =
            assembler->assemble(square(size_m, static_cast<std::uint64_t>(1e6 * size_m))).points;
        ASSERT_EQ(points.size(), 1);
        EXPECT_TRUE(points.absolute);
        const int whole = assembler->assemble(square(0.1, 99)).points.size();
        EXPECT_GT(whole, 50);
        EXPECT_LT(points.targets[0], focus_Pa(points) / std::sqrt(whole));
        EXPECT_GT(points.targets[0], 0.1 * focus_Pa(points) / std::sqrt(whole));
    }
}

TEST_F(SmallObject, InPascalItIsHeldToTheSameAndNeverRaised)
{
    SceneSnapshot snapshot = square(4e-5);
    snapshot.objects[0].properties.pressureInPa = true;
    snapshot.objects[0].properties.pressure = 90000.0;
    const haptics::ControlPoints loud = assembler->assemble(snapshot).points;
    EXPECT_LT(loud.targets[0], 0.1 * focus_Pa(loud));
    snapshot.objects[0].properties.pressure = 5.0;
    EXPECT_EQ(assembler->assemble(snapshot).points.targets[0], 5.0);
}

TEST_F(SmallObject, BesideAWholeOneItGetsAShareAndTheWholeOneStaysAsItIs)
{
    SceneSnapshot snapshot = square(0.04, 3);
    HapticObject small = square(4e-5).objects[0];
    small.id = snapshot.objects[0].id + 1;
    small.path = "Scene/small";
    small.pose.translation().x() = 0.05;
    snapshot.objects.push_back(small);
    const haptics::ControlPoints points = assembler->assemble(snapshot).points;
    EXPECT_EQ(asked("Scene/small: is "), 1);
    EXPECT_EQ(asked(), 0);
    EXPECT_FALSE(points.absolute);
    for (int i = 0; i < points.size(); ++i)
        if (points.object[static_cast<std::size_t>(i)] == 0)
            EXPECT_EQ(points.targets[i], 1.0);
        else
            EXPECT_LT(points.targets[i], 0.6);
}

TEST_F(SmallObject, PointsAndPartsOfAWholeAreAsTheyWereMeant)
{
    SceneSnapshot snapshot = square(4e-5);
    snapshot.objects[0].properties.sampling = haptics::Sampling::POINTS;
    EXPECT_FALSE(assembler->assemble(snapshot).points.absolute);
    // Rivets of one thing, each by itself under half a wavelength.
    snapshot = square(0.002);
    HapticObject other = snapshot.objects[0];
    snapshot.objects[0].whole = other.whole = 77;
    other.id = snapshot.objects[0].id + 1;
    other.pose.translation().x() = 0.03;
    snapshot.objects.push_back(other);
    EXPECT_FALSE(assembler->assemble(snapshot).points.absolute);
    EXPECT_TRUE(messages.messages().empty()) << messages.all()[0];
}

// A plate through the middle of boards that face each other hears as much from both of its sides.
TEST_F(SmallObject, ASideThatIsATieIsTold)
{
    const haptics::TransducerArray octagon = haptics::TransducerArray::octagonalPrism();
    PointAssembler::Options options;
    options.wavelength_m = 8.58e-3;
    PointAssembler around(octagon, options, messages);
    SceneSnapshot snapshot = square(0.04);
    snapshot.objects[0].pose.translation().z() = 0.0;
    snapshot.objects[0].properties.side = Side::FRONT;
    around.assemble(snapshot);
    around.assemble(snapshot);
    ASSERT_EQ(messages.messages().size(), 1u);
    EXPECT_EQ(messages.messages()[0].code, base::MessageCode::OBJECT_SIDE);
    EXPECT_NE(messages.all()[0].find("Scene/square: side=front: "), std::string::npos);
    // Before one board there is none.
    snapshot = square(0.04);
    snapshot.objects[0].pose.linear() =
        Eigen::AngleAxisd(0.5 * M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
    snapshot.objects[0].properties.side = Side::FRONT;
    assembler->assemble(snapshot);
    EXPECT_EQ(messages.messages().size(), 1u);
}
