//! Resources: holders, waiting tasks, and remaining amounts (`pdl.md`, Procedures, Conflicts).

use crate::state::resource_id::ResourceId;
use crate::state::waiting::Waiting;
use apex_model::library::ResourceKind;
use apex_model::quantity::Dimension;
use apex_model::task::TaskId;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Amount of a resource that a task needs to be ongoing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Need {
    /// Resource.
    pub resource: ResourceId,
    /// Units of a capacity, amount of a depletable in SI, 1 of a unitary resource.
    pub amount: f64,
}

/// A part of a resource that a task holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Holding {
    /// The holder.
    pub task: TaskId,
    /// Amount.
    pub amount: f64,
}

/// One resource.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resource {
    /// Its name.
    pub name: Value,
    /// Total amount: 1, the capacity, or the rest of a depletable resource (reservations included), in SI.
    pub total: f64,
    /// True if its use consumes it.
    pub depletable: bool,
    /// Amount of the full resource, if it can be replenished.
    #[serde(default)]
    pub renewable: Option<f64>,
    /// The dimension of amounts.
    pub dimension: Dimension,
    /// Holders, in order of acquisition. Several holders of one unit are ancestors and descendants.
    pub holders: Vec<Holding>,
    /// Enabled and interrupted tasks that claim it.
    pub waiting: Waiting,
}

/// All resources that tasks have named so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResourceTable {
    resources: Vec<Resource>,
    names: BTreeMap<Value, ResourceId>,
}

impl ResourceTable {
    /// Returns the resource's number, if it was named before.
    pub fn find(&self, name: &Value) -> Option<ResourceId> {
        self.names.get(name).copied()
    }

    /// Returns the number of the resource `name`; a new one is created with `kind`.
    pub fn intern(&mut self, name: &Value, kind: &ResourceKind) -> ResourceId {
        if let Some(id) = self.find(name) {
            return id;
        }
        let (total, depletable, dimension) = match kind {
            ResourceKind::Unitary => (1.0, false, Dimension::NONE),
            ResourceKind::Capacity(units) => (f64::from(*units), false, Dimension::NONE),
            ResourceKind::Depletable(amount) | ResourceKind::Renewable(amount) => {
                let (si, dimension) = amount.as_number().unwrap_or((0.0, Dimension::NONE));
                (si, true, dimension)
            }
        };
        let renewable = matches!(kind, ResourceKind::Renewable(_)).then_some(total);
        let id = ResourceId(u32::try_from(self.resources.len()).unwrap_or(u32::MAX));
        let (holders, waiting) = (Vec::new(), Waiting::default());
        let name_known = name.clone();
        self.resources.push(Resource { name: name_known, total, depletable, renewable, dimension, holders, waiting });
        self.names.insert(name.clone(), id);
        id
    }

    /// Returns the resource with this number.
    pub fn get(&self, id: ResourceId) -> Option<&Resource> {
        self.resources.get(id.0 as usize)
    }

    /// Returns the resource with this number, mutably.
    pub fn get_mut(&mut self, id: ResourceId) -> Option<&mut Resource> {
        self.resources.get_mut(id.0 as usize)
    }

    /// Returns all resources in order of first use.
    pub fn iter(&self) -> impl Iterator<Item = (ResourceId, &Resource)> {
        (0_u32..).map(ResourceId).zip(self.resources.iter())
    }
}
