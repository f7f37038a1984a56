#include "engine-bridge/scene/Convert.h"
#include "haptics/base/threads/Mutex.h"
#include "haptics/points/ControlPointSelector.h"
#include "haptics/probe/FingertipForce.h"
#include "haptics/propagation/PressureField.h"
#include "plugin/engine/HapticEngine.h"
#include "plugin/extending/ArrayConversion.h"
#include "plugin/scene/SceneCollector.h"

#include <osgMidair/HapticField>

#include <algorithm>
#include <cmath>
#include <utility>

namespace osgMidair
{

using midair::bridge::HologramResult;

struct HapticField::Data
{
    std::shared_ptr<const HologramResult> result; ///< not null; has a field and an array
    std::vector<Object> objects;
    std::vector<ControlPoint> points;
    bool isPlaying = false;

    explicit Data(std::shared_ptr<const HologramResult> newest);

    void fillPoints();
    /// Returns \a places in the array's frame, 3 x n; the origin for those that are not finite.
    Eigen::Matrix3Xd inArray(const std::vector<osg::Vec3d>& places) const;
    const Eigen::VectorXcf* fieldAt(unsigned int field) const;
};

namespace
{

bool isFinite(const osg::Vec3d& place)
{
    return std::isfinite(place.x()) && std::isfinite(place.y()) && std::isfinite(place.z());
}

void setLeftOut(HapticField::Object& object, const midair::bridge::ObjectPoints& points)
{
    const auto number = [](int count) { return static_cast<unsigned int>(count); };
    object.outOfWorkspace = number(points.leftOut.outOfWorkspace);
    object.overBudget = number(points.leftOut.overBudget);
    object.crowded = number(points.leftOut.crowded);
    object.unpainted = number(points.leftOut.noTarget);
    object.invalid = number(points.leftOut.notFinite);
    object.outOfReach = number(points.outOfReach);
    object.isUnreachable = points.isUnreachable;
}

/// Returns the force on a fingertip at \a place (world), on the way in which the nearest of the
/// points is played.
midair::haptics::FingertipForce forceAt(const midair::bridge::HologramResult& result,
                                        const osg::Vec3d& place,
                                        const osg::Vec3d& normal)
{
    if (!isFinite(place) || !isFinite(normal)) return {};
    const Eigen::Affine3d toArray(result.worldToArray);
    const Eigen::Vector3d at = toArray * midair::bridge::toEigen(place);
    Eigen::Index nearest = 0;
    if (result.points.size() > 0)
        (result.points.positions.colwise() - at).colwise().squaredNorm().minCoeff(&nearest);
    midair::haptics::FingertipForce force =
        midair::haptics::fingertipForce(at,
                                        toArray.linear() * midair::bridge::toEigen(normal),
                                        *result.array,
                                        result.medium,
                                        result.sequence,
                                        nearest >= result.points.size() - result.foci);
    force.threshold_N = result.fingertip.threshold_N;
    return force;
}

} // namespace

HapticField::Data::Data(std::shared_ptr<const HologramResult> newest) : result(std::move(newest))
{
    objects.resize(result->origins.size());
    for (std::size_t i = 0; i < objects.size(); ++i)
        if (const auto* felt = static_cast<const FeltNode*>(result->origins[i].get()))
        {
            objects[i].node = felt->node;
            objects[i].path = felt->path;
        }
    for (std::size_t i = 0; i < std::min(objects.size(), result->objects.size()); ++i)
        setLeftOut(objects[i], result->objects[i]);
    const bool sounds =
        std::any_of(result->sequence.fields.begin(),
                    result->sequence.fields.end(),
                    [](const Eigen::VectorXcf& q) { return q.size() > 0 && !q.isZero(0.0F); });
    isPlaying = result->playing && result->deviceOpen && sounds;
    fillPoints();
}

void HapticField::Data::fillPoints()
{
    const midair::haptics::ControlPoints& given = result->points;
    const Eigen::Affine3d toWorld(Eigen::Matrix4d(result->worldToArray.inverse()));
    const double largest = given.size() > 0 ? given.targets.maxCoeff() : 0.0;
    const double unit_Pa = given.absolute  ? 1.0
                           : largest > 0.0 ? result->report().level_Pa / largest
                                           : 0.0;
    points.resize(static_cast<std::size_t>(given.size()));
    for (int l = 0; l < given.size(); ++l)
    {
        ControlPoint& point = points[static_cast<std::size_t>(l)];
        point.position = midair::bridge::toOsg((toWorld * given.positions.col(l)).eval());
        if (given.normals.cols() > l)
            point.normal = midair::bridge::toOsg(
                // a similarity: it changes only the length
                (toWorld.linear() * given.normals.col(l)).eval());
        point.normal.normalize();
        point.wanted_Pa = unit_Pa * given.targets[l];
        point.achieved_Pa =
            l < result->achieved_Pa.size() ? static_cast<double>(result->achieved_Pa[l]) : 0.0;
        if (!given.object.empty())
            point.object = static_cast<unsigned int>(given.object[static_cast<std::size_t>(l)]);
    }
    std::size_t done = 0;
    for (std::size_t k = 0; k < result->sequence.parts.size(); ++k)
        for (int l = 0; l < result->sequence.parts[k].size() && done < points.size(); ++l)
            points[done++].field = static_cast<unsigned int>(k);
}

Eigen::Matrix3Xd HapticField::Data::inArray(const std::vector<osg::Vec3d>& places) const
{
    const Eigen::Affine3d toArray(result->worldToArray);
    Eigen::Matrix3Xd there = Eigen::Matrix3Xd::Zero(3, static_cast<Eigen::Index>(places.size()));
    for (std::size_t i = 0; i < places.size(); ++i)
        if (isFinite(places[i]))
            there.col(static_cast<Eigen::Index>(i)) = toArray * midair::bridge::toEigen(places[i]);
    return there;
}

const Eigen::VectorXcf* HapticField::Data::fieldAt(unsigned int field) const
{
    const auto& fields = result->sequence.fields;
    return field < fields.size() ? &fields[field] : nullptr;
}

HapticField::HapticField(std::unique_ptr<const Data> data) :
    osg::Referenced(true),
    _data(std::move(data))
{
}

HapticField::~HapticField() = default;

std::uint64_t HapticField::getFrameNumber() const
{
    return _data->result->frame;
}

double HapticField::getSimulationTime() const
{
    return _data->result->simulationTime_s;
}

double HapticField::getHandedOverTime() const
{
    return _data->result->handedOver_s;
}

bool HapticField::isPlaying() const
{
    return _data->isPlaying;
}

const std::vector<HapticField::ControlPoint>& HapticField::getPoints() const
{
    return _data->points;
}

const std::vector<HapticField::Object>& HapticField::getObjects() const
{
    return _data->objects;
}

unsigned int HapticField::getNumFields() const
{
    return static_cast<unsigned int>(_data->result->sequence.fields.size());
}

double HapticField::getFieldRate() const
{
    return getNumFields() > 1 ? _data->result->sequence.modulation.fieldRate_Hz : 0.0;
}

std::vector<std::complex<float>> HapticField::getActivations(unsigned int field) const
{
    const Eigen::VectorXcf* q = _data->fieldAt(field);
    return q ? std::vector<std::complex<float>>(q->data(), q->data() + q->size())
             : std::vector<std::complex<float>>();
}

std::complex<float> HapticField::getPressure(const osg::Vec3d& place, unsigned int field) const
{
    return getPressures({place}, field).front();
}

std::vector<std::complex<float>> HapticField::getPressures(const std::vector<osg::Vec3d>& places,
                                                           unsigned int field) const
{
    std::vector<std::complex<float>> pressures(places.size());
    const Eigen::VectorXcf* q = _data->fieldAt(field);
    if (!q || places.empty()) return pressures;
    const Eigen::VectorXcf p = midair::haptics::pressureAt(
        _data->inArray(places), *_data->result->array, _data->result->medium, *q);
    for (std::size_t i = 0; i < places.size(); ++i)
        if (isFinite(places[i])) pressures[i] = p[static_cast<Eigen::Index>(i)];
    return pressures;
}

std::vector<float> HapticField::getFeltPressures(const std::vector<osg::Vec3d>& places) const
{
    std::vector<float> felt(places.size());
    if (places.empty()) return felt;
    const Eigen::VectorXd square =
        midair::haptics::meanSquarePressure(_data->inArray(places),
                                            *_data->result->array,
                                            _data->result->medium,
                                            _data->result->sequence.fields);
    for (std::size_t i = 0; i < places.size(); ++i)
        if (isFinite(places[i]))
            felt[i] = static_cast<float>(std::sqrt(square[static_cast<Eigen::Index>(i)]));
    return felt;
}

double HapticField::getFingertipForce(const osg::Vec3d& place, const osg::Vec3d& normal) const
{
    return forceAt(*_data->result, place, normal).force_N;
}

std::string HapticField::getFeeling(const osg::Vec3d& place, const osg::Vec3d& normal) const
{
    return forceAt(*_data->result, place, normal).feeling();
}

std::string HapticField::forceText(double force_N)
{
    return midair::haptics::forceText(force_N);
}

osg::Matrixd HapticField::getWorldToArray() const
{
    return midair::bridge::toOsg(_data->result->worldToArray);
}

std::shared_ptr<const ArrayDescription> HapticField::getArray() const
{
    return std::make_shared<const ArrayDescription>(describe(*_data->result->array));
}

double HapticField::getWavelength() const
{
    return _data->result->medium.wavelength(_data->result->array->frequency_Hz);
}

double HapticField::getReach() const
{
    if (_data->result->array->size() == 0) return 0.0;
    return midair::haptics::Workspace(*_data->result->array, getWavelength(), {}).reach_m();
}

// The origins of a result are FeltNodes.
osg::ref_ptr<const HapticField>
HapticEngine::publicForm(std::shared_ptr<const HologramResult> result)
{
    return new HapticField(std::make_unique<const HapticField::Data>(std::move(result)));
}

osg::ref_ptr<const HapticField> HapticEngine::field() const
{
    const auto result = latestResult();
    if (!result || !result->array || result->sequence.fields.empty()) return nullptr;
    const midair::base::Lock lock(_newest->mutex);
    if (_newest->result != result)
    {
        _newest->field = publicForm(result);
        _newest->result = result;
    }
    return _newest->field;
}

} // namespace osgMidair
