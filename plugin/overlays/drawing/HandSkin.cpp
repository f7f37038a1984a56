#include "plugin/overlays/drawing/HandSkin.h"

#include "haptics/base/Units.h"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace osgMidair
{

namespace
{

using namespace midair::bridge;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Joints in the palm, independent of the fingers.
constexpr std::array<int, 10> kPalmJoints = {WRIST,
                                             THUMB_METACARPAL,
                                             INDEX_METACARPAL,
                                             INDEX_PROXIMAL,
                                             MIDDLE_METACARPAL,
                                             MIDDLE_PROXIMAL,
                                             RING_METACARPAL,
                                             RING_PROXIMAL,
                                             LITTLE_METACARPAL,
                                             LITTLE_PROXIMAL};
constexpr double kLargest = 3.0;     ///< times the hand at rest; the smallest is the inverse
constexpr double kShortest_m = 1e-4; ///< shortest bone with a direction
/// Bends of the joints of an untracked finger.
constexpr std::array<double, kChainBones> kCurled_deg = {75.0, 95.0, 60.0};

std::size_t at(int index)
{
    return static_cast<std::size_t>(index);
}

double bounded(double ratio)
{
    return std::clamp(ratio, 1.0 / kLargest, kLargest);
}

Matrix3d bend(double angle_deg)
{
    return Eigen::AngleAxisd(-midair::base::toRadians(angle_deg), Vector3d::UnitX())
        .toRotationMatrix();
}

/// Returns the linear map that scales by \a along in the direction \a way at rest, and by \a across
/// perpendicular to it.
Matrix3d stretched(const Vector3d& way, double along, double across)
{
    return across * Matrix3d::Identity() + (along - across) * way * way.transpose();
}

} // namespace

std::pair<int, int> jointsOfBone(int bone)
{
    constexpr int kThumbBones = 4;
    constexpr int kFingerBones = 5;
    const bool isThumb = bone < kThumbBones;
    const int finger = isThumb ? 0 : (bone - kThumbBones) / kFingerBones;
    const int along = isThumb ? bone : (bone - kThumbBones) % kFingerBones;
    const int root = isThumb ? THUMB_METACARPAL : INDEX_METACARPAL + kFingerBones * finger;
    return {along == 0 ? static_cast<int>(WRIST) : root + along - 1, root + along};
}

void HandSkin::takeJoints(const std::vector<HandCapsule>& capsules, int hand)
{
    _joints.fill({});
    _side = isLeft(hand) ? -1.0 : 1.0;
    for (const HandCapsule& capsule : capsules)
    {
        const bool isUsable = capsule.hand == hand && capsule.shape.a.allFinite() &&
                              capsule.shape.b.allFinite() && capsule.shape.radius_m > 0.0;
        if (!isUsable) continue;
        const auto [from, to] = jointsOfBone(capsule.bone);
        _joints[at(from)].place = capsule.shape.a;
        _joints[at(from)].isKnown = true;
        _joints[at(to)] = {capsule.shape.b, capsule.shape.radius_m, true};
    }
}

Vector3d HandSkin::atRest(int joint) const
{
    const Vector3d& place = handMesh().joints[at(joint)];
    return {_side * place.x(), place.y(), place.z()};
}

/// Finds the best rotation and scale (Kabsch, Umeyama).
bool HandSkin::findPalm(Palm& palm) const
{
    int count = 0;
    for (const int joint : kPalmJoints)
    {
        if (!_joints[at(joint)].isKnown) continue;
        palm.from += atRest(joint);
        palm.to += _joints[at(joint)].place;
        ++count;
    }
    if (count < 3) return false;
    palm.from /= count;
    palm.to /= count;
    Matrix3d both = Matrix3d::Zero();
    double rest = 0.0;
    double now = 0.0;
    for (const int joint : kPalmJoints)
    {
        if (!_joints[at(joint)].isKnown) continue;
        const Vector3d from = atRest(joint) - palm.from;
        const Vector3d to = _joints[at(joint)].place - palm.to;
        both += to * from.transpose();
        rest += from.squaredNorm();
        now += to.squaredNorm();
    }
    palm.scale = std::sqrt(now / rest);
    if (!(palm.scale > 1.0 / kLargest && palm.scale < kLargest)) return false;
    const Eigen::JacobiSVD<Matrix3d> svd(both, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Vector3d& size = svd.singularValues();
    if (!(size[1] > 0.01 * size[0])) return false; // collinear: no plane
    Matrix3d signs = Matrix3d::Identity();
    signs(2, 2) = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
    palm.turn = svd.matrixU() * signs * svd.matrixV().transpose();
    return true;
}

void HandSkin::setFrame(int frame, const Matrix3d& linear, const Vector3d& from, const Vector3d& to)
{
    Matrix3d ofMesh = linear; // of the right hand's, mirrored for a left one
    ofMesh.col(0) *= _side;
    Eigen::Matrix4f& matrix = _frames[at(frame)];
    matrix.setIdentity();
    matrix.topLeftCorner<3, 3>() = ofMesh.cast<float>();
    matrix.topRightCorner<3, 1>() = (to - linear * from).cast<float>();
}

/// Each bone turns with the previous one, and from there by the shortest rotation: twist is
/// inherited.
void HandSkin::placeFinger(const Palm& palm, int finger)
{
    const HandMesh& mesh = handMesh();
    Matrix3d turn = palm.turn;
    const Joint& first = _joints[at(chainJoint(finger, 0))];
    Vector3d begin = first.isKnown
                         ? first.place
                         : Vector3d(palm.to + palm.scale * palm.turn *
                                                  (atRest(chainJoint(finger, 0)) - palm.from));
    for (int k = 0; k < kChainBones; ++k)
    {
        const int joint = chainJoint(finger, k);
        const Vector3d rest = atRest(joint);
        const Vector3d bone = atRest(joint + 1) - rest;
        const Vector3d way = bone.normalized();
        const Joint& next = _joints[at(joint + 1)];
        const bool hasWay = next.isKnown && (next.place - begin).norm() > kShortest_m;
        const Matrix3d before = turn;
        if (hasWay)
            turn = Eigen::Quaterniond::FromTwoVectors(turn * way, next.place - begin) * turn;
        else if (!next.isKnown)
            turn = turn * bend(finger == THUMB ? 25.0 : kCurled_deg[at(k)]) *
                   Eigen::AngleAxisd(
                       midair::base::toRadians(k == 0 ? -_side * spreadAtRest_deg(finger) : 0.0),
                       Vector3d::UnitY());
        const double along =
            bounded(next.isKnown ? (next.place - begin).norm() / bone.norm() : palm.scale);
        const double radius_m = 0.5 * (mesh.radii_m[at(joint)] + mesh.radii_m[at(joint + 1)]);
        const double across = bounded(next.isKnown ? next.radius_m / radius_m : palm.scale);
        const Eigen::Quaterniond half =
            Eigen::Quaterniond(before).slerp(0.5, Eigen::Quaterniond(turn));
        setFrame(jointFrame(finger, k), across * half.toRotationMatrix(), rest, begin);
        setFrame(jointFrame(finger, k) + 1, turn * stretched(way, along, across), rest, begin);
        begin = next.isKnown ? next.place : Vector3d(begin + along * turn * bone);
    }
}

bool HandSkin::move(const std::vector<HandCapsule>& capsules,
                    int hand,
                    osg::Vec3Array& vertices,
                    osg::Vec3Array& normals)
{
    takeJoints(capsules, hand);
    Palm palm;
    if (!findPalm(palm)) return false;
    setFrame(0, palm.scale * palm.turn, palm.from, palm.to);
    for (int finger = 0; finger < kHandChains; ++finger)
        placeFinger(palm, finger);
    const HandMesh& mesh = handMesh();
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    {
        const HandMesh::Skin& skin = mesh.skin[i];
        Eigen::Matrix4f motion = skin.shares[0] * _frames[skin.frames[0]];
        for (std::size_t k = 1; k < skin.count; ++k)
            motion += skin.shares[k] * _frames[skin.frames[k]];
        const Eigen::Vector3f& from = mesh.vertices[i];
        const Eigen::Vector3f& out = mesh.normals[i];
        const Eigen::Vector4f place = motion.col(0) * from.x() + motion.col(1) * from.y() +
                                      motion.col(2) * from.z() + motion.col(3);
        const Eigen::Vector4f normal =
            motion.col(0) * out.x() + motion.col(1) * out.y() + motion.col(2) * out.z();
        vertices[i].set(place.x(), place.y(), place.z());
        normals[i].set(normal.x(), normal.y(), normal.z());
    }
    return true;
}

} // namespace osgMidair
