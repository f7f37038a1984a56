#include "engine-bridge/pipeline/MotionStage.h"

#include "engine-bridge/hands/tracking/NamedSource.h"
#include "haptics/base/Percentile.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace midair::bridge
{

// The clock of motions. A simulation slower than real time moves objects more slowly; one that is
// faster, or whose frames come faster than its time passes, must not look like a fast motion.
void MotionStage::passTime(const SceneSnapshot& snapshot)
{
    _now.time_s += std::max(
        {snapshot.time_s - _now.steady_s, snapshot.simulationTime_s - _now.simulation_s, 0.0});
    _now.steady_s = snapshot.time_s;
    _now.simulation_s = snapshot.simulationTime_s;
    _now.lightAfter_s = *snapshot.lightAfter_s;
    ++_now.frame;
    _work.since_s = _context.clock.now_s();
}

// Time from the light of the newest snapshot to its sound.
double MotionStage::ahead_s() const
{
    if (_work.last_s.empty()) return 0.0;
    const double sound_s =
        _work.since_s + base::percentile(_work.last_s, 0.5) + TrackedDelay::kSound_s;
    return sound_s - _now.steady_s - _now.lightAfter_s;
}

bool MotionStage::isTouched(const HapticObject& object) const
{
    return followsHands(object.properties, _context.options.contacts.shares.render);
}

void MotionStage::measure(const HapticObject& object, Followed& of)
{
    if (of.isMeasured && of.meshId == object.meshId) return;
    of.corners.setZero();
    if (object.mesh && object.mesh->vertices.cols() > 0)
        of.corners = boxCorners(object.mesh->vertices);
    of.isMeasured = true;
    of.meshId = object.meshId;
}

// Hands that aren't predicted lag, and touched objects must lag as much.
Eigen::Isometry3d MotionStage::poseOf(const HapticObject& object,
                                      const SceneSnapshot& snapshot,
                                      double ahead_s,
                                      bool isSeen)
{
    Followed& of = _objects[object.id];
    of.frame = _now.frame;
    of.motion.see(_now.time_s, object.pose);
    if ((isSeen && !of.isMeasured) || of.motion.isMoving()) measure(object, of);
    const Eigen::Vector3d middle = of.corners.rowwise().mean();
    of.errors.see(_now.time_s, object.pose * middle);
    const bool isLate = snapshot.handsLate_s > 0.0 && isTouched(object);
    Eigen::Isometry3d pose = snapshot.carriesOn && !isLate && of.motion.isMoving()
                                 ? of.motion.at(ahead_s, of.corners)
                                 : object.pose;
    of.played = pose * middle;
    return pose;
}

bool MotionStage::arrive(const SceneSnapshot*& snapshot)
{
    if (!snapshot->lightAfter_s)
    {
        _objects.clear();
        noteSeen(*snapshot);
        return true;
    }
    passTime(*snapshot);
    const double ahead = ahead_s();
    const SceneSnapshot& given = *snapshot;
    for (std::size_t i = 0; i < given.objects.size(); ++i)
    {
        const HapticObject& object = given.objects[i];
        const Eigen::Isometry3d pose = poseOf(object, given, ahead, i < kMostSeen);
        if (pose.matrix() == object.pose.matrix()) continue;
        if (snapshot != &_moved) _moved = given;
        snapshot = &_moved;
        _moved.objects[i].pose = pose;
    }
    for (auto one = _objects.begin(); one != _objects.end();)
        one = one->second.frame == _now.frame ? std::next(one) : _objects.erase(one);
    noteSeen(given);
    return true;
}

void MotionStage::noteSeen(const SceneSnapshot& snapshot)
{
    const base::Lock lock(_seen.mutex);
    _seen.objects.resize(std::min(snapshot.objects.size(), kMostSeen));
    for (std::size_t i = 0; i < _seen.objects.size(); ++i)
    {
        const HapticObject& object = snapshot.objects[i];
        SeenObject& seen = _seen.objects[i];
        if (seen.path != object.path) seen.path = object.path;
        seen.id = object.id;
        seen.isTouched = isTouched(object);
        const auto followed = _objects.find(object.id);
        const bool isKnown = followed != _objects.end();
        seen.place = isKnown ? followed->second.played : object.pose.translation();
        seen.motion = isKnown ? followed->second.errors.reading() : MotionError();
    }
}

std::vector<SeenObject> MotionStage::seen() const
{
    const base::Lock lock(_seen.mutex);
    return _seen.objects;
}

void MotionStage::report(HologramResult& result, bool /*isOtherField*/)
{
    const double since_s = std::exchange(_work.since_s, 0.0);
    if (!(since_s > 0.0) || !(result.handedOver_s >= since_s)) return;
    const double taken_s = result.handedOver_s - since_s;
    if (_work.last_s.size() < Work::kMost)
        _work.last_s.push_back(taken_s);
    else
        _work.last_s[_work.count % Work::kMost] = taken_s;
    ++_work.count;
    const double sound_s = result.handedOver_s + TrackedDelay::kSound_s;
    const double seen_s = _now.time_s + sound_s - _now.steady_s - _now.lightAfter_s;
    for (auto& [id, of] : _objects)
        of.errors.feel(seen_s, of.played);
}

} // namespace midair::bridge
