#pragma once

#include "plugin/gltf/GltfMeshes.h"
#include "plugin/gltf/GltfMessages.h"
#include "plugin/gltf/GltfMotion.h"

#include <osg/Group>
#include <osg/MatrixTransform>
#include <osg/Matrixd>
#include <osg/ref_ptr>

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace osgMidair
{

/// Makes the nodes of a model below one that is theirs.
class GltfNodes
{
public:
    static constexpr int kDeepest = 200; ///< OSG's visitors go as deep
    static constexpr std::size_t kMostNodes = 200000;
    static constexpr std::size_t kMostSkinnedParts = 10000;

    /// Throws GltfError if the nodes are no trees, are too many or have no place.
    GltfNodes(GltfReading& from, GltfSkins& skins, GltfMeshes& meshes);

    /// Adds the nodes of scene \a scene (-1: all that have no parent) below \a root, which is the
    /// skeleton if there are skins.
    void addTo(osg::Group& root, int scene);

private:
    void findParents();
    void checkDepth() const;
    void nameNodes();
    void addAll(const std::vector<int>& numbers, osg::Group& to);
    osg::ref_ptr<osg::Node> make(int number);
    osg::ref_ptr<osg::MatrixTransform> transformOf(int number);
    void addMesh(int number, osg::Group& node);
    osg::ref_ptr<osg::Node> sharedMesh(int number);
    /// Adds \a mesh once, or as often as EXT_mesh_gpu_instancing of node \a number says.
    void addInstances(int number, osg::Node& mesh, osg::Group& node);
    void addSkinned(int number);
    std::string nameForMessages(int number) const;
    /// The extras of a node's mesh; null: it has none.
    const tinygltf::Value& meshExtras(int number) const;
    /// Where a node is in the model at rest, of all nodes.
    const std::vector<osg::Matrixd>& places();

    GltfReading& _from;
    GltfSkins& _skins;
    GltfMeshes& _meshes;
    std::vector<int> _parents; ///< -1: none
    std::vector<std::string> _names;
    std::vector<bool> _isMoved;
    /// meshes without skins, by their numbers and the weights of their morph targets
    std::map<std::pair<int, std::vector<double>>, osg::ref_ptr<osg::Node>> _shared;
    std::vector<osg::Matrixd> _places; ///< of places(); empty: not asked for yet
    std::size_t _instances = 0;
    std::vector<osg::ref_ptr<osg::Node>> _skinnedNodes; ///< to be added below the root
    std::size_t _skinned = 0;
};

} // namespace osgMidair
