#include "plugin/overlays/drawing/HandSkin.h"

#include "plugin/overlays/drawing/HandMesh.h"

#include <osg/Array>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

using namespace osgMidair;
namespace bridge = midair::bridge;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace
{

std::vector<bridge::HandCapsule> capsulesOf(const bridge::Hand& hand)
{
    bridge::HandFrame frame;
    frame.hands = {hand};
    return bridge::handCapsules(frame);
}

/// A hand somewhere, turned, with its fingers bent by \a bend_rad at each joint.
bridge::Hand bentHand(int id, double bend_rad)
{
    Eigen::Isometry3d palm = Eigen::Isometry3d::Identity();
    palm.linear() = Eigen::AngleAxisd(0.8, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    palm.translation() = Vector3d(0.03, -0.2, 0.4);
    bridge::Hand hand = bridge::openHand(id, palm);
    for (int finger = 1; finger < kHandChains; ++finger)
        for (int k = 0; k < kChainBones; ++k)
        {
            const auto from = static_cast<std::size_t>(chainJoint(finger, k));
            const Vector3d about = hand.joints[from].position;
            const Eigen::AngleAxisd turn(-bend_rad, palm.linear().col(0));
            for (int next = k + 1; next <= kChainBones; ++next)
            {
                Vector3d& at =
                    hand.joints[static_cast<std::size_t>(chainJoint(finger, next))].position;
                at = about + turn * (at - about);
            }
        }
    return hand;
}

struct Moved
{
    explicit Moved(const bridge::Hand& hand) : Moved(capsulesOf(hand), hand.id) {}
    Moved(const std::vector<bridge::HandCapsule>& bones, int id) : capsules(bones)
    {
        isThere = skin.move(capsules, id, *vertices, *normals);
    }
    Vector3d at(std::size_t i) const
    {
        return Vector3d((*vertices)[i].x(), (*vertices)[i].y(), (*vertices)[i].z());
    }
    Vector3d normal(std::size_t i) const
    {
        return Vector3d((*normals)[i].x(), (*normals)[i].y(), (*normals)[i].z());
    }
    bool isFinite() const
    {
        return std::all_of(vertices->begin(),
                           vertices->end(),
                           [](const osg::Vec3& v) { return v.valid(); }) &&
               std::all_of(
                   normals->begin(), normals->end(), [](const osg::Vec3& v) { return v.valid(); });
    }
    /// Below 0: inside out.
    double volume_m3(bool isLeft) const
    {
        const std::vector<unsigned int>& corners = handMesh().triangles;
        double volume = 0.0;
        for (std::size_t i = 0; i < corners.size(); i += 3)
            volume += at(corners[i]).dot(at(corners[i + 1]).cross(at(corners[i + 2]))) / 6.0;
        return isLeft ? -volume : volume;
    }

    std::vector<bridge::HandCapsule> capsules;
    osg::ref_ptr<osg::Vec3Array> vertices = new osg::Vec3Array(handMesh().vertices.size());
    osg::ref_ptr<osg::Vec3Array> normals = new osg::Vec3Array(handMesh().vertices.size());
    HandSkin skin;
    bool isThere = false;
};

/// Distance of \a at from the skin of a capsule: what touches are computed with.
double distance(const bridge::HandCapsule& capsule, const Vector3d& at)
{
    const Vector3d way = capsule.shape.b - capsule.shape.a;
    const double t = std::clamp((at - capsule.shape.a).dot(way) / way.squaredNorm(), 0.0, 1.0);
    return (at - capsule.shape.a - t * way).norm() - capsule.shape.radius_m;
}

} // namespace

TEST(HandMesh, IsClosedAndSmooth)
{
    const HandMesh& mesh = handMesh();
    ASSERT_GT(mesh.vertices.size(), 3000U);
    ASSERT_LT(mesh.vertices.size(), 10000U);
    ASSERT_EQ(mesh.skin.size(), mesh.vertices.size());
    std::map<std::pair<unsigned int, unsigned int>, int> edges;
    for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
        for (std::size_t k = 0; k < 3; ++k)
            ++edges[{mesh.triangles[i + k], mesh.triangles[i + (k + 1) % 3]}];
    for (const auto& [edge, count] : edges)
    {
        EXPECT_EQ(count, 1);
        EXPECT_EQ(edges.count({edge.second, edge.first}), 1U) << "a hole";
    }
    // Between the normals of neighbours: no edge is seen but where fingers part.
    std::size_t sharp = 0;
    for (const auto& [edge, count] : edges)
        if (mesh.normals[edge.first].dot(mesh.normals[edge.second]) < 0.7F) ++sharp;
    EXPECT_LT(sharp, edges.size() / 100);
    for (const HandMesh::Skin& skin : mesh.skin)
    {
        float sum = 0.0F;
        for (int i = 0; i < skin.count; ++i)
            sum += skin.shares[static_cast<std::size_t>(i)];
        EXPECT_NEAR(sum, 1.0F, 1e-5F);
    }
}

TEST(HandSkin, KnowsTheJointsOfBones)
{
    for (int bone = 0; bone < bridge::kHandBones; ++bone)
    {
        const auto [from, to] = jointsOfBone(bone);
        EXPECT_EQ(bridge::boneName(bone),
                  std::string(bridge::jointName(from)) + " to " + bridge::jointName(to));
    }
}

/// The skin is where touches are computed: fingers to 2.5 mm of their capsules, bent or not.
TEST(HandSkin, FollowsTheJoints)
{
    for (const int id : {0, 1})
        for (const double bend_rad : {0.0, 0.3, 1.0, 1.4})
        {
            const Moved hand(bentHand(id, bend_rad));
            ASSERT_TRUE(hand.isThere);
            ASSERT_TRUE(hand.isFinite());
            const HandMesh& mesh = handMesh();
            double worst_m = 0.0;
            for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
            {
                const int bone = mesh.skin[i].bone;
                const bool isFinger =
                    bone > 3 && (bone - 4) % 5 > 1 &&
                    mesh.skin[i].frames[0] == jointFrame((bone + 1) / 5, (bone - 4) % 5 - 2) + 1;
                if (!isFinger || mesh.skin[i].shares[0] < 0.95F) continue;
                double nearest_m = 1.0;
                for (const bridge::HandCapsule& capsule : hand.capsules)
                    nearest_m = std::min(nearest_m, distance(capsule, hand.at(i)));
                worst_m = std::max(worst_m, std::abs(nearest_m));
            }
            EXPECT_GT(worst_m, 0.0);
            EXPECT_LT(worst_m, 2.5e-3) << id << ", " << bend_rad;
        }
}

TEST(HandSkin, IsNoHandInsideOut)
{
    const double right_m3 = Moved(bentHand(1, 0.3)).volume_m3(false);
    EXPECT_GT(right_m3, 200e-6);
    EXPECT_LT(right_m3, 500e-6);
    EXPECT_NEAR(Moved(bentHand(0, 0.3)).volume_m3(true), right_m3, 1e-6) << "mirrored";
    const HandMesh& mesh = handMesh();
    for (const int id : {0, 1})
    {
        const Moved hand(bentHand(id, 0.9));
        std::size_t wrong = 0;
        for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
        {
            const unsigned int* corners = &mesh.triangles[i];
            const Vector3d face = (hand.at(corners[1]) - hand.at(corners[0]))
                                      .cross(hand.at(corners[2]) - hand.at(corners[0]));
            if ((id == 0 ? -1.0 : 1.0) * face.dot(hand.normal(corners[0])) <= 0.0) ++wrong;
        }
        EXPECT_LT(wrong, mesh.triangles.size() / 3 / 30) << id << ", but for folds";
    }
}

/// A tracker's hand may be smaller, or not all there; there is no place that isn't one.
TEST(HandSkin, IsFiniteWithDegenerateHands)
{
    bridge::Hand small = bentHand(1, 0.2);
    for (bridge::HandJoint& joint : small.joints)
        joint.position *= 0.7;
    EXPECT_TRUE(Moved(small).isThere);
    EXPECT_TRUE(Moved(small).isFinite());

    bridge::Hand pointing = bentHand(1, 0.0);
    for (int joint = bridge::MIDDLE_INTERMEDIATE; joint < bridge::HAND_JOINTS; ++joint)
        if ((joint - bridge::MIDDLE_METACARPAL) % 5 > 1)
            pointing.joints[static_cast<std::size_t>(joint)].positionValid = false;
    const Moved curled(pointing);
    EXPECT_TRUE(curled.isThere);
    EXPECT_TRUE(curled.isFinite());
    EXPECT_LT(curled.volume_m3(false), 450e-6);

    bridge::Hand point = bentHand(1, 0.0);
    for (bridge::HandJoint& joint : point.joints)
        joint.position = Vector3d(0.1, 0.2, 0.3);
    EXPECT_FALSE(Moved(point).isThere);
    bridge::Hand line = bentHand(1, 0.0);
    for (std::size_t i = 0; i < line.joints.size(); ++i)
        line.joints[i].position = Vector3d(0.008 * static_cast<double>(i), 0.0, 0.0);
    EXPECT_FALSE(Moved(line).isThere);
    bridge::Hand bones = bentHand(0, 0.0); // no bone of a finger has a length
    for (int finger = 0; finger < kHandChains; ++finger)
        for (int k = 1; k <= kChainBones; ++k)
            bones.joints[static_cast<std::size_t>(chainJoint(finger, k))].position =
                bones.joints[static_cast<std::size_t>(chainJoint(finger, 0))].position;
    EXPECT_TRUE(Moved(bones).isFinite());
    EXPECT_FALSE(Moved({}, 1).isThere);
    std::vector<bridge::HandCapsule> broken = capsulesOf(bentHand(1, 0.0));
    broken[7].shape.b.y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(Moved(broken, 1).isFinite());
}
