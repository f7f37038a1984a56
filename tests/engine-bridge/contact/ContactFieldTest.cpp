#include "engine-bridge/contact/ContactField.h"

#include "haptics/base/InputError.h"
#include "haptics/base/Units.h"
#include "haptics/propagation/ReferencePropagation.h"
#include "tests/engine-bridge/contact/ContactNumbers.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace midair::bridge
{

namespace
{

using Eigen::Vector3d;

ContactFocus focusAt(const Vector3d& place, double pressure_Pa, int index = 0)
{
    ContactFocus focus;
    focus.position = focus.centre = place;
    focus.pressure_Pa = pressure_Pa;
    focus.contact = 1;
    focus.index = index;
    return focus;
}

std::vector<ContactFocus> circle(int count, double radius_m, double turn_rad, double pressure_Pa)
{
    std::vector<ContactFocus> foci;
    for (int j = 0; j < count; ++j)
    {
        const double angle = turn_rad + base::kTwoPi * j / count;
        foci.push_back(
            focusAt(Vector3d(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.15),
                    pressure_Pa,
                    j));
        foci.back().centre = Vector3d(0, 0, 0.15);
    }
    return foci;
}

class ContactFieldTest : public testing::Test
{
public:
    double pressureAt(const Vector3d& place, const Eigen::VectorXcf& q) const
    {
        const Eigen::MatrixXcd G =
            haptics::referencePropagationMatrix(Eigen::Matrix3Xd(place), array, air);
        return std::abs((G * q.cast<std::complex<double>>())(0));
    }
    double mostAt(const Vector3d& place) const
    {
        return haptics::referencePropagationMatrix(Eigen::Matrix3Xd(place), array, air)
            .cwiseAbs()
            .sum();
    }

    haptics::TransducerArray array = haptics::TransducerArray::singleBoard();
    haptics::Medium air;
    Eigen::VectorXcf q;
    std::string error;
};

TEST_F(ContactFieldTest, OneFocusHasConjugatePhasesAndItsPressure)
{
    ContactField field(array, air);
    const Vector3d place(0.01, -0.02, 0.15);
    ASSERT_TRUE(field.solve({focusAt(place, 1000.0)}, q, &error)) << error;
    EXPECT_NEAR(pressureAt(place, q), 1000.0, 10.0);
    ASSERT_TRUE(field.solve({focusAt(place, 1e5)}, q, &error));
    EXPECT_NEAR(pressureAt(place, q), mostAt(place), 1e-3 * mostAt(place)); // all it can
    EXPECT_LE(q.cwiseAbs().maxCoeff(), 1.0f + 1e-6f);
}

TEST_F(ContactFieldTest, SeveralFociHaveTheirPressures)
{
    ContactField field(array, air);
    for (const int count : {2, 4, 10})
    {
        const auto foci = circle(count, count < 10 ? 6e-3 : 15e-3, 0.3, 300.0);
        ASSERT_TRUE(field.solve(foci, q, &error)) << error;
        EXPECT_LE(q.cwiseAbs().maxCoeff(), 1.0f + 1e-6f);
        for (const ContactFocus& focus : foci)
            EXPECT_NEAR(pressureAt(focus.position, q), 300.0, 0.03 * 300.0) << count;
    }
}

// The foci turn in small steps: each field is much the one before, with no turn in common. Now and
// then the solver finds other phases between the foci, which costs some of it.
TEST_F(ContactFieldTest, TheCommonPhaseGoesOn)
{
    ContactField field(array, air);
    for (const int count : {1, 4})
    {
        Eigen::VectorXcf before;
        for (int i = 0; i < 60; ++i)
        {
            const auto foci = circle(count, 4e-3, 0.05 * i, 2000.0);
            ASSERT_TRUE(field.solve(foci, q, &error));
            if (i > 0)
            {
                const std::complex<float> product = before.dot(q);
                EXPECT_LT(std::abs(std::arg(product)), 0.03f) << count; // half a level is 0.012
                if (i > 10)
                {
                    EXPECT_GT(product.real(), 0.8f * before.norm() * q.norm()) << i;
                }
            }
            before = q;
        }
    }
}

TEST_F(ContactFieldTest, TheMaskKeepsWhatIsNotBehindTheFinger)
{
    array = haptics::TransducerArray::octagonalPrism();
    ContactFieldOptions options;
    options.mask = true;
    ContactField field(array, air, options);
    ContactFocus focus = focusAt(Vector3d(0.03, 0, 0), 3000.0);
    focus.normal = Vector3d::UnitX(); // the finger is at x > 0.03, sound has to come from -x
    std::vector<ContactFocus> foci = {focus, focus, focus};
    for (int j = 0; j < 3; ++j)
    {
        foci[static_cast<std::size_t>(j)].index = j;
        foci[static_cast<std::size_t>(j)].position.y() += 6e-3 * j;
    }
    for (const auto& played : {std::vector<ContactFocus>{focus}, foci})
    {
        ASSERT_TRUE(field.solve(played, q, &error)) << error;
        int off = 0;
        for (int i = 0; i < array.size(); ++i)
        {
            const Vector3d way = (array.positions.col(i) - focus.centre).normalized();
            const bool isKept = way.dot(-Vector3d::UnitX()) > -0.3;
            EXPECT_EQ(std::abs(q[i]) > 0.0f, isKept) << i;
            off += isKept ? 0 : 1;
        }
        EXPECT_GT(off, 1000);
        EXPECT_EQ(field.driven(), array.size() - off);
        for (const ContactFocus& one : played)
            EXPECT_NEAR(pressureAt(one.position, q), 3000.0, 0.03 * 3000.0);
    }
}

// From the second field on the solver gets its own copy of the array.
TEST_F(ContactFieldTest, FollowsReflectorsAndRefusalsAsANewOneDoes)
{
    haptics::Reflector wall;
    wall.position = Vector3d(0.2, 0, 0);
    wall.normal = Vector3d(-1, 0, 0);
    wall.along = Vector3d(0, 1, 0);
    wall.accuracy_mm = 0.1;
    const std::vector<ContactFocus> beside = {focusAt(Vector3d(0, 0, 0.15), 1000.0)};
    const std::vector<ContactFocus> inWall = {focusAt(Vector3d(0.199, 0, 0.15), 1000.0)};
    haptics::TransducerArray walled = array;
    walled.reflectors = {wall};
    ContactField field(walled, air);
    EXPECT_FALSE(field.solve(inWall, q, &error)) << "the solver hasn't had an array so far";
    EXPECT_TRUE(field.solve(beside, q, &error)) << error;
    for (const bool isWalled : {true, true, false, false, true})
    {
        if (!isWalled) walled.reflectors.clear();
        if (isWalled) walled.reflectors = {wall};
        field.setReflectors(walled.reflectors);
        for (int again = 0; again < 2; ++again)
        {
            Eigen::VectorXcf fresh;
            ASSERT_TRUE(field.solve(beside, q, &error)) << error;
            ASSERT_TRUE(ContactField(walled, air).solve(beside, fresh, &error)) << error;
            const std::complex<float> product = q.dot(fresh);
            EXPECT_GT(std::abs(product), 0.999f * q.norm() * fresh.norm())
                << isWalled << ' ' << again;
        }
    }
}

TEST_F(ContactFieldTest, BadInputIsSilence)
{
    ContactField field(array, air);
    ASSERT_TRUE(field.solve({}, q, &error));
    EXPECT_EQ(q.size(), array.size());
    EXPECT_TRUE(q.isZero());
    for (const ContactFocus& focus : {focusAt(Vector3d(kNan, 0, 0.15), 100.0),
                                      focusAt(Vector3d(0, 0, 0.15), kNan),
                                      focusAt(Vector3d(0, 0, 0.15), -1.0),
                                      focusAt(Vector3d(0, 0, 100.0), 100.0)})
    {
        error.clear();
        EXPECT_FALSE(field.solve({focus}, q, &error));
        EXPECT_TRUE(q.isZero());
        EXPECT_NE(error.find("a focus of a contact has"), std::string::npos);
    }
    EXPECT_FALSE(field.solve(circle(201, 0.05, 0, 10.0), q, &error));
    EXPECT_EQ(error, "contacts have 201 foci; at most 200 are played at once");
    EXPECT_TRUE(q.isZero());
    ContactFieldOptions options;
    options.maskCosine = kNan;
    EXPECT_THROW(ContactField(array, air, options), base::InputError);
}

} // namespace

} // namespace midair::bridge
