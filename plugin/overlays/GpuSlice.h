#pragma once

#include "haptics/array/Medium.h"
#include "haptics/array/TransducerArray.h"
#include "plugin/overlays/FieldSlice.h"

#include <osg/Camera>
#include <osg/Drawable>
#include <osg/Texture2D>
#include <osg/buffered_value>

#include <atomic>
#include <memory>

namespace osgMidair
{

/// What draws in the contexts that have drawn so far.
enum class Renderer
{
    UNKNOWN, ///< none has
    SOFTWARE,
    GPU
};

/// Finds out what draws, with the drawable's first frame; \a found may be read from any thread.
osg::ref_ptr<osg::Drawable::DrawCallback>
probeRenderer(const std::shared_ptr<std::atomic<Renderer>>& found);

/// A slice that a fragment shader computes: every texel sums up all transducers, into a texture as
/// the SliceComputer's, once a field and context.
class GpuSlice
{
public:
    GpuSlice();

    void setArray(const midair::haptics::TransducerArray& array,
                  const midair::haptics::Medium& medium);
    /// The disc and the field of \a request, coloured up to \a range_Pa.
    void setRequest(const SliceRequest& request, float range_Pa);

    osg::Texture2D* texture() { return _texture; }

    /// Renders in the context of \a visitor if that hasn't been done since the last change.
    void cull(osg::NodeVisitor& visitor);

private:
    osg::ref_ptr<osg::Texture2D> _texture;
    osg::ref_ptr<osg::Camera> _camera;
    osg::ref_ptr<osg::Image> _places;  ///< xyz in wavelengths
    osg::ref_ptr<osg::Image> _normals; ///< xyz
    osg::ref_ptr<osg::Image> _drive;   ///< re, im in Pa
    osg::ref_ptr<osg::Image> _directivity;
    osg::ref_ptr<osg::Uniform> _rows, _middle, _u, _v, _beta, _nearest, _range;
    std::vector<std::complex<float>> _strength; ///< of each transducer at full drive
    double _wavelength_m = 1.0;
    unsigned int _serial = 0;
    osg::buffered_value<unsigned int> _rendered; ///< the serial, by context
};

} // namespace osgMidair
