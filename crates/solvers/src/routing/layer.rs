//! Networks of the legs to which the same zones and the same speed apply.

use super::zones::ZoneSet;
use apex_geo::geodesy::Position;
use apex_geo::travel::{EndpointId, Network, TravelError};

/// A network at a speed, with the numbers of the nodes in it.
pub(super) struct Layer {
    pub(super) zones: ZoneSet,
    pub(super) true_airspeed_mps: f64,
    pub(super) network: Network,
    pub(super) places: Vec<Option<Result<EndpointId, TravelError>>>,
}

impl Layer {
    /// Returns the number of a node in the network; adds the node when it is first needed.
    pub(super) fn place(
        &mut self,
        node: usize,
        position: Position,
        track_rad: Option<f64>,
    ) -> Result<EndpointId, TravelError> {
        if let Some(Some(known)) = self.places.get(node) {
            return known.clone();
        }
        let place = self.network.add(position);
        if let Ok(place) = &place {
            self.network.head(*place, track_rad);
        }
        if let Some(slot) = self.places.get_mut(node) {
            *slot = Some(place.clone());
        }
        place
    }
}
