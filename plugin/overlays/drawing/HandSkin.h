#pragma once

#include "engine-bridge/hands/Hand.h"
#include "plugin/overlays/drawing/HandMesh.h"

#include <osg/Array>

#include <Eigen/Geometry>

#include <array>
#include <utility>
#include <vector>

namespace osgMidair
{

/// The joints of bone 0 .. bridge::kHandBones - 1, of bridge::HandJointName.
std::pair<int, int> jointsOfBone(int bone);

/// Moves the skin of HandMesh by the bones of a hand. Untracked fingers are curled; a hand without
/// a tracked palm has no skin. Ids: 0 left, 1 right; of other ids even ones are left.
class HandSkin
{
public:
    /// Moves \a vertices and \a normals (as many elements as the mesh has vertices; normals aren't
    /// unit where a finger is thicker than at rest) by the bones of \a hand among \a capsules.
    /// Returns false, with both unchanged, for a hand without a skin.
    bool move(const std::vector<midair::bridge::HandCapsule>& capsules,
              int hand,
              osg::Vec3Array& vertices,
              osg::Vec3Array& normals);

    static bool isLeft(int hand) { return hand % 2 == 0; }

private:
    struct Joint
    {
        Eigen::Vector3d place = Eigen::Vector3d::Zero();
        double radius_m = 0.0; ///< of the bone that ends here, or begins
        bool isKnown = false;
    };
    /// The palm's pose, relative to rest.
    struct Palm
    {
        Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
        double scale = 1.0;
        Eigen::Vector3d from = Eigen::Vector3d::Zero();
        Eigen::Vector3d to = Eigen::Vector3d::Zero();
    };

    void takeJoints(const std::vector<midair::bridge::HandCapsule>& capsules, int hand);
    Eigen::Vector3d atRest(int joint) const;
    bool findPalm(Palm& palm) const;
    void placeFinger(const Palm& palm, int finger);
    void setFrame(int frame,
                  const Eigen::Matrix3d& linear,
                  const Eigen::Vector3d& from,
                  const Eigen::Vector3d& to);

    std::array<Joint, midair::bridge::HAND_JOINTS> _joints;
    double _side = 1.0; ///< of x; -1: a left hand
    std::array<Eigen::Matrix4f, kHandFrames> _frames;
};

} // namespace osgMidair
