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

/// \{ Names of the animated parts of a node's transform.
constexpr const char* kGltfTranslation = "translation";
constexpr const char* kGltfRotation = "rotation";
constexpr const char* kGltfScale = "scale";
/// \}

/// Returns "node 12": the name by which animations find a node's transform.
std::string gltfTargetName(int node);

/// Returns for each node whether an animation moves it.
std::vector<bool> movedByGltf(const tinygltf::Model& model);

/// Lets an animation manager at \a root repeat the model's first animation; programs can use the
/// others. Invalid channels are left out with a message.
void addGltfAnimations(GltfReading& from, osg::Node& root);

/// The skins of a model: finds the bones, and makes geometries that follow them in software, so
/// that the played shape follows, too.
class GltfSkins
{
public:
    /// Throws GltfError if a skin has an invalid reference.
    explicit GltfSkins(GltfReading& from);

    /// True for joints and for their ancestors by \a parents: a bone's pose is known only through
    /// bones.
    bool isBone(int node) const { return _isBone[static_cast<std::size_t>(node)]; }
    void addParents(const std::vector<int>& parents);

    /// Transform from a joint's vertices at rest to its own frame.
    const osg::Matrixd& inverseBind(int node) const
    {
        return _inverse[static_cast<std::size_t>(node)];
    }

    /// Returns \a part moved by skin \a skin and the bones of \a names; before these move, at the
    /// nodes' \a places at rest.
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
