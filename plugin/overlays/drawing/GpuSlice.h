#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "plugin/overlays/drawing/FieldSlice.h"

#include <osg/Camera>
#include <osg/Drawable>
#include <osg/Texture2D>
#include <osg/buffered_value>

#include <atomic>
#include <memory>

namespace osgMidair
{

/// Kind of renderer of the contexts used until now.
enum class Renderer
{
    UNKNOWN, ///< none was used yet
    SOFTWARE,
    GPU
};

/// Makes a draw callback that determines the renderer in the drawable's first frame. \a found may
/// be read from any thread.
osg::ref_ptr<osg::Drawable::DrawCallback>
probeRenderer(const std::shared_ptr<std::atomic<Renderer>>& found);

/// A slice computed by a fragment shader: each texel sums over all transducers. Its texture looks
/// like the SliceComputer's and is rendered once per field and context.
class GpuSlice
{
public:
    GpuSlice();

    void setArray(const midair::haptics::TransducerArray& array,
                  const midair::haptics::Medium& medium);
    /// Sets disc and field from \a request, with \a range_Pa at the map's upper end.
    void setRequest(const SliceRequest& request, float range_Pa);

    osg::Texture2D* texture() { return _texture; }

    /// Renders the texture in the context of \a visitor, unless it is up to date there.
    void cull(osg::NodeVisitor& visitor);

private:
    osg::ref_ptr<osg::Texture2D> _texture;
    osg::ref_ptr<osg::Camera> _camera;
    osg::ref_ptr<osg::Image> _places;  ///< xyz in wavelengths
    osg::ref_ptr<osg::Image> _normals; ///< xyz
    osg::ref_ptr<osg::Image> _drive;   ///< re, im in Pa
    osg::ref_ptr<osg::Image> _directivity;
    osg::ref_ptr<osg::Uniform> _rows, _middle, _u, _v, _beta, _nearest, _range;
    /// emitted amplitude of each transducer at full drive
    std::vector<std::complex<float>> _strength;
    double _wavelength_m = 1.0;
    unsigned int _serial = 0;
    osg::buffered_value<unsigned int> _rendered; ///< _serial when last rendered, by context
};

} // namespace osgMidair
