#include "engine-bridge/scene/Convert.h"
#include "haptics/base/Limits.h"
#include "haptics/base/SmallMatrices.h"
#include "haptics/base/UserEnvironment.h"
#include "haptics/base/threads/SteadyClock.h"
#include "plugin/overlays/OverlayPart.h"
#include "plugin/overlays/drawing/DiscGeometry.h"
#include "plugin/overlays/drawing/FieldSlice.h"
#include "plugin/overlays/drawing/GpuSlice.h"

#include <osgMidair/FieldSliceOverlay>

#include <osg/Geometry>
#include <osg/Image>
#include <osg/Notify>
#include <osg/PolygonOffset>
#include <osg/Texture2D>
#include <osgGA/GUIEventAdapter>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <string>

namespace osgMidair
{

namespace
{

/// Makes a square with \a texture, whose alpha has the disc's shape. The caller sets the vertices.
osg::ref_ptr<osg::Geometry> makeSliceDisc(osg::Texture2D* texture)
{
    // The centres of the outermost texels lie on the rim.
    constexpr float kFirst = 0.5F / kSlicePixels;
    osg::ref_ptr<osg::Geometry> disc = osg::createTexturedQuadGeometry(
        {}, osg::X_AXIS, osg::Y_AXIS, kFirst, kFirst, 1.0F - kFirst, 1.0F - kFirst);
    disc->setDataVariance(osg::Object::DYNAMIC);
    disc->setUseDisplayList(false);
    disc->setUseVertexBufferObjects(true);
    osg::StateSet* state = disc->getOrCreateStateSet();
    state->setTextureAttributeAndModes(0, texture);
    // The slice of a flat object is in its plane; the offset keeps the object in front.
    state->setAttributeAndModes(new osg::PolygonOffset(1.0F, 1.0F));
    return disc;
}

const OverlayNumber kFieldSliceRadius =
    overlayNumber<FieldSliceOverlay, &FieldSliceOverlay::setRadius, &FieldSliceOverlay::getRadius>(
        "sliceRadius",
        "radius of the slice; 0: 16 mm beyond the farthest control point",
        {0.0, 0.5}, // the computing time grows with its square, and a scene's file may set it
        "m");
const OverlayNumber kRange = overlayNumber<FieldSliceOverlay,
                                           &FieldSliceOverlay::setRange,
                                           &FieldSliceOverlay::getWantedRange>(
    "sliceRange",
    "pressure at the upper end of the slice's colour map; 0: follows the largest",
    {0.0, midair::base::kMostPressure_Pa},
    "Pa");

const OverlayRegistration kFieldSliceRegistration(
    {2,
     "FieldSlice",
     "slice",
     "the slice of the field",
     "a slice of the pressure through the points or a plane of your own, in Pa (peak)",
     osgGA::GUIEventAdapter::KEY_F3,
     30,
     makeOverlay<FieldSliceOverlay>,
     {kFieldSliceRadius, kRange}});

/// Ratio of the smallest to the second largest spread below which points count as flat, and above
/// which they no longer do. The two differ so that a moving object doesn't flicker between the
/// states.
constexpr double kFlat = 0.08;
constexpr double kNotFlat = 0.14;

/// s between the thread's slices while the GPU draws, for the peak and the range.
constexpr double kBeside_s = 0.25;

/// Returns the method in the environment, or \a otherwise; warns once about an invalid name.
FieldSliceOverlay::Method methodOf(FieldSliceOverlay::Method otherwise)
{
    const std::string asked = midair::base::variableNow("OSG_MIDAIR_SLICE").value_or("");
    if (asked.empty()) return otherwise;
    if (asked == "auto") return FieldSliceOverlay::AUTO;
    if (asked == "cpu") return FieldSliceOverlay::CPU;
    if (asked == "gpu") return FieldSliceOverlay::GPU;
    static std::once_flag once;
    std::call_once(once,
                   [&]
                   {
                       OSG_WARN << "osgMidair: OSG_MIDAIR_SLICE is \"" << asked
                                << "\", should be auto, cpu or gpu" << std::endl;
                   });
    return otherwise;
}

/// The felt places of \a result, array frame: the foci of contacts, else the control points.
Eigen::Matrix3Xd feltPlaces(const midair::bridge::HologramResult& result)
{
    Eigen::Matrix3Xd foci(3, 0);
    if (result.touched)
        for (const midair::bridge::ContactView& contact : result.touched->contacts)
        {
            foci.conservativeResize(3, foci.cols() + contact.foci.cols());
            foci.rightCols(contact.foci.cols()) = contact.foci;
        }
    return foci.cols() > 0 ? foci : result.points.positions;
}

double median(Eigen::VectorXd values)
{
    const Eigen::Index middle = values.size() / 2;
    std::nth_element(values.data(), values.data() + middle, values.data() + values.size());
    return values[middle];
}

} // namespace

/// A textured disc; the worker's thread or a fragment shader fills the texture.
class FieldSliceOverlay::Part : public OverlayPart
{
public:
    explicit Part(FieldSliceOverlay& owner) :
        _owner(owner),
        _image(new osg::Image),
        _renderer(std::make_shared<std::atomic<Renderer>>(Renderer::UNKNOWN))
    {
        _image->allocateImage(kSlicePixels, kSlicePixels, 1, GL_RGBA, GL_UNSIGNED_BYTE);
        _image->setDataVariance(DYNAMIC);
        _texture = makeTexture(_image, true);
        _disc = makeSliceDisc(_texture);
        drawTranslucent(*_disc, SLICE_BIN);
        _disc->setDrawCallback(probeRenderer(_renderer));
    }

    void setArray(const std::shared_ptr<const midair::haptics::TransducerArray>& array,
                  const midair::haptics::Medium& medium) override
    {
        _array = array;
        _medium = medium;
        if (gpu) gpu->setArray(*array, medium);
    }

    void setResult(const std::shared_ptr<const midair::bridge::HologramResult>& result) override
    {
        if (!_array || result->played().size() != _array->size()) return;
        chooseMethod();
        const Eigen::Matrix3Xd points = feltPlaces(*result);
        SliceRequest request;
        request.frame = result->frame;
        request.array = _array;
        request.medium = _medium;
        request.result = result;
        Eigen::Vector3d normal = Eigen::Vector3d::UnitY();
        if (points.cols() > 0)
        {
            request.centre = points.rowwise().mean();
            const Eigen::Matrix3Xd d = points.colwise() - request.centre;
            const midair::base::SymmetricAxes<3> spread =
                midair::base::symmetricAxes(Eigen::Matrix3d(d * d.transpose()));
            const Eigen::Vector3d& sizes = spread.values;
            _flat = points.cols() > 2 && sizes[0] < (_flat ? kNotFlat : kFlat) * sizes[1];
            if (_flat) normal = spread.vectors.col(0);
            // The median puts the slice where most points are: a raised middle doesn't move it off
            // the outline.
            request.centre += normal * median(normal.transpose() * d);
        }
        if (_owner._plane)
        {
            normal = midair::bridge::toEigen(_owner._plane->normal).normalized();
            const Eigen::Vector3d on = midair::bridge::toEigen(_owner._plane->point);
            request.centre += normal * normal.dot(on - request.centre);
        }
        request.u = normal.unitOrthogonal();
        request.v = normal.cross(request.u);
        request.radius_m = _owner._radius_m;
        if (request.radius_m <= 0.0)
        {
            const Eigen::Matrix3Xd d = points.colwise() - request.centre;
            const double reach =
                points.cols() > 0 ? std::sqrt(d.colwise().squaredNorm().maxCoeff()) : 0.04;
            // Rounded up in steps, so that the disc's size stays constant while the object turns.
            request.radius_m = 0.005 * std::ceil((reach + 0.016) / 0.005 - 1e-6);
        }
        request.range_Pa = _owner._range_Pa;
        if (!worker) worker = startSlices(); // no thread before the first use
        const double now = midair::base::steadySeconds();
        // The shader needs a range, which the thread's first slice provides.
        const bool onGpu = gpu && _owner._shownRange_Pa > 0.0F;
        if (onGpu) showOnGpu(request);
        if (onGpu && now - _submitted_s < kBeside_s) return;
        _submitted_s = now;
        worker->submit(std::move(request));
    }

    void show(const Slice& slice)
    {
        _owner._peak = midair::bridge::toOsg(slice.peak);
        _owner._peak_Pa = slice.peak_Pa;
        _owner._compute_ms = slice.compute_ms;
        const bool first = _owner._shownRange_Pa <= 0.0F;
        _owner._shownRange_Pa = slice.range_Pa;
        if (gpu)
        {
            if (first) showOnGpu(slice.request);
            return;
        }
        std::copy(slice.texels.begin(), slice.texels.end(), _image->data());
        _image->dirty();
        place(slice.request);
        count(slice.frame);
    }

    std::unique_ptr<SliceWorker> worker;
    std::unique_ptr<GpuSlice> gpu; ///< null: the GPU is not used

private:
    void showOnGpu(const SliceRequest& request)
    {
        gpu->setRequest(request, _owner._shownRange_Pa);
        place(request);
        count(request.frame);
    }

    void place(const SliceRequest& request)
    {
        auto& corners = static_cast<osg::Vec3Array&>(*_disc->getVertexArray());
        const auto& places = static_cast<const osg::Vec2Array&>(*_disc->getTexCoordArray(0));
        const Eigen::Vector3d u = request.u * request.radius_m;
        const Eigen::Vector3d v = request.v * request.radius_m;
        for (std::size_t i = 0; i < corners.size(); ++i)
            corners[i] = osgVec(request.centre + (places[i].x() < 0.5F ? -u : u) +
                                (places[i].y() < 0.5F ? -v : v));
        corners.dirty();
        _disc->dirtyBound();
        if (_owner.getNumChildren() == 0) _owner.addChild(_disc);
    }

    void count(std::uint64_t frame)
    {
        _owner._shownFrame = frame;
        const double now = midair::base::steadySeconds();
        // Exponential mean over about ten slices.
        if (_lastShown_s > 0.0)
            _owner._slicesPerSecond +=
                0.1 * (1.0 / std::max(1e-4, now - _lastShown_s) - _owner._slicesPerSecond);
        _lastShown_s = now;
    }

    void chooseMethod()
    {
        const Method wanted = methodOf(_owner._method);
        const Renderer renderer = *_renderer;
        // With software rendering the shader takes a second for a slice that the SliceComputer
        // makes in milliseconds.
        // The shader knows only the direct way of sound.
        const bool isFree = !_array || _array->reflectors.empty();
        const bool onGpu =
            isFree && (wanted == GPU || (wanted == AUTO && renderer == Renderer::GPU));
        if (onGpu == (gpu != nullptr) || !_array) return;
        if (onGpu)
        {
            gpu = std::make_unique<GpuSlice>();
            gpu->setArray(*_array, _medium);
        }
        osg::Texture2D* texture = onGpu ? gpu->texture() : _texture.get();
        _disc->getOrCreateStateSet()->setTextureAttributeAndModes(0, texture);
        if (!onGpu) gpu.reset();
    }

    FieldSliceOverlay& _owner; ///< gets the disc with the first slice
    std::shared_ptr<const midair::haptics::TransducerArray> _array;
    midair::haptics::Medium _medium;
    bool _flat = false; ///< the points of the last result were flat
    osg::ref_ptr<osg::Geometry> _disc;
    osg::ref_ptr<osg::Image> _image;
    osg::ref_ptr<osg::Texture2D> _texture; ///< of _image
    std::shared_ptr<std::atomic<Renderer>> _renderer;
    double _submitted_s = 0.0;
    double _lastShown_s = 0.0;
};

FieldSliceOverlay::FieldSliceOverlay() :
    Overlay(std::make_unique<Part>(*this)),
    _part(static_cast<Part&>(OverlayPart::of(*this)))
{
    setNumChildrenRequiringUpdateTraversal(1);
}

FieldSliceOverlay::~FieldSliceOverlay() = default;

bool FieldSliceOverlay::isOnGpu() const
{
    return _part.gpu != nullptr;
}

void FieldSliceOverlay::traverse(osg::NodeVisitor& visitor)
{
    if (visitor.getVisitorType() == osg::NodeVisitor::UPDATE_VISITOR && _part.worker)
        if (const std::unique_ptr<Slice> slice = _part.worker->take()) _part.show(*slice);
    if (visitor.getVisitorType() == osg::NodeVisitor::CULL_VISITOR && _part.gpu)
        _part.gpu->cull(visitor);
    Overlay::traverse(visitor);
}

bool FieldSliceOverlay::waitFor(std::uint64_t frame, double timeout_s)
{
    if (getNumChildren() > 0 && _shownFrame >= frame) return true;
    if (!_part.worker) return false;
    const std::unique_ptr<Slice> slice = _part.worker->waitFor(frame, timeout_s);
    if (slice) _part.show(*slice);
    return slice && slice->request.frame >= frame;
}

} // namespace osgMidair
