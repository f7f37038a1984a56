#pragma once

#include "plugin/gltf/GltfFile.h"
#include "plugin/gltf/GltfMeshes.h"
#include "plugin/gltf/GltfScene.h"

#include <osg/Geometry>
#include <osg/Matrixd>
#include <osg/Node>
#include <osg/ref_ptr>

#include <string>
#include <vector>

namespace osgMidair
{

/// \{ Names of what animations move at a node's transform.
constexpr const char* kGltfTranslation = "translation";
constexpr const char* kGltfRotation = "rotation";
constexpr const char* kGltfScale = "scale";
/// \}

/// "node 12": the name by which animations find a node's transform.
std::string gltfTargetName(int node);

/// For each node whether an animation moves it.
std::vector<bool> movedByGltf(const tinygltf::Model& model);

/// Lets an animation manager at \a root play the model's first animation over and over; others are
/// there for programs. A channel that is wrong is left out, and told.
void addGltfAnimations(GltfReading& from, osg::Node& root);

/// The skins of a model: which nodes are bones, and geometries that follow them, by software, so
/// that what is felt follows, too.
class GltfSkins
{
public:
    /// Throws GltfError if a skin refers to what isn't there.
    explicit GltfSkins(GltfReading& from);

    /// True for joints, and for the nodes \a parents says are above them: a bone's place is known
    /// through bones alone.
    bool isBone(int node) const { return _isBone[static_cast<std::size_t>(node)]; }
    void addParents(const std::vector<int>& parents);

    /// From a joint's vertices at rest to its own frame.
    const osg::Matrixd& inverseBind(int node) const
    {
        return _inverse[static_cast<std::size_t>(node)];
    }

    /// \a part as skin \a skin moves it, as bones of \a names do; until they do, where the nodes'
    /// \a places at rest lead it.
    osg::ref_ptr<osg::Geometry> follow(const GltfPart& part,
                                       int skin,
                                       const std::vector<std::string>& names,
                                       const std::vector<osg::Matrixd>& places);

private:
    void readSkin(const tinygltf::Skin& skin);
    osg::ref_ptr<osg::Vec3Array> atRest(const GltfPart& part,
                                        const std::vector<int>& joints,
                                        const std::vector<osg::Matrixd>& places) const;

    GltfReading& _from;
    std::vector<bool> _isBone;
    std::vector<bool> _isJoint;
    std::vector<osg::Matrixd> _inverse;
};

} // namespace osgMidair
